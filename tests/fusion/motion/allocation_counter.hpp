#pragma once

#include <cstddef>

namespace infuse::motion {

/// What this test program has taken from the heap so far; stays 0 under sanitizers, whose own
/// allocator is left in place.
size_t allocation_count();

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kAllocationsCounted = false;
#else
inline constexpr bool kAllocationsCounted = true;
#endif

}  // namespace infuse::motion
