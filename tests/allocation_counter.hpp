#pragma once

#include <cstddef>

namespace infuse {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
/// False under sanitizers, whose own allocator stays in place.
inline constexpr bool kAllocationsCounted = false;
#else
inline constexpr bool kAllocationsCounted = true;
#endif

/// Number of calls of operator new in this test program so far; 0 under sanitizers.
/// A test program links it by the option ALLOCATIONS of infuse_test.
size_t allocation_count();

/// As `allocation_count`, but only on the threads named "io" and "fusion", and counted from the
/// first call of this function on.
size_t streaming_allocation_count();

}  // namespace infuse
