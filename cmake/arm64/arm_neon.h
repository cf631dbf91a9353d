// Comes before the compiler's header of this name on arm64, so that Eigen's vector code gives the bytes of amd64 there.
// Eigen multiplies and adds with NEON's fused instructions, called by name, which -ffp-contract=off does not reach: a
// fused instruction rounds once where SSE2 and the rest of the code round twice. Here the same names mean a product and
// a sum.
#pragma once
#pragma GCC system_header
#include_next <arm_neon.h>

#undef __ARM_FEATURE_FMA
#define vfmaq_n_f32(c, a, b) vaddq_f32(c, vmulq_n_f32(a, b))
#define vfmaq_n_f64(c, a, b) vaddq_f64(c, vmulq_n_f64(a, b))
#define vfmaq_laneq_f32(c, a, b, lane) vaddq_f32(c, vmulq_laneq_f32(a, b, lane))
#define vfmaq_laneq_f64(c, a, b, lane) vaddq_f64(c, vmulq_laneq_f64(a, b, lane))

// Where Eigen has a fused instruction it multiplies matrices in blocks of three vectors instead of two, and the rows
// that are left over are summed in another order. A plug-in of its is the place between the two that can say otherwise.
#define EIGEN_MATRIXBASE_PLUGIN "cmake/arm64/eigen_blocks.hpp"
