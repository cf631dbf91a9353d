#pragma once

/// Put before a function: it is compiled for AVX-512, AVX2 and the plain processor, and the best
/// one is taken at run time. Such a function treats each element alone (no sums across elements),
/// so that every variant gives the same bytes. The thread sanitizer cannot start programs that
/// choose functions at load time.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define INFUSE_SIMD_CLONES __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define INFUSE_SIMD_CLONES
#endif
