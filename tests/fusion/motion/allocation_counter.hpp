#pragma once

#include <cstddef>

namespace infuse::motion {

/// Number of heap allocations of this test program so far; always 0 under sanitizers, whose own
/// allocator is left in place.
size_t allocation_count();

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kAllocationsCounted = false;
#else
inline constexpr bool kAllocationsCounted = true;
#endif

}  // namespace infuse::motion
