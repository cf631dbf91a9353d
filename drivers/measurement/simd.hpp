#pragma once

/// Function attribute: compiles the function for AVX-512, AVX2 and the baseline processor, and
/// selects the best variant at load time; elsewhere the baseline has the vectors (arm64: NEON).
/// Such a function processes each element independently (no sums across elements), so that every
/// variant gives the same bytes. Disabled under the thread sanitizer, which cannot start programs
/// that select functions at load time.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define INFUSE_SIMD_CLONES __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define INFUSE_SIMD_CLONES
#endif

/// Function attribute: compiles the function for an instruction set of x86-64 ("avx2"). On other
/// processors it means nothing: `supported()` is false there, so the function is never selected.
#ifdef __x86_64__
#define INFUSE_TARGET(set) __attribute__((target(set)))
#else
#define INFUSE_TARGET(set)
#endif
