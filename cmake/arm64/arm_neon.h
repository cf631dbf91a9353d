// Comes before the compiler's header of this name on arm64. Eigen's vector code there multiplies and adds with NEON's
// fused instructions, called by name, which -ffp-contract=off does not reach. A fused instruction rounds once where
// SSE2 and the rest of the code round twice, so a replay would give other bytes than on amd64. Here the same names
// mean a product and a sum.
#pragma once
#pragma GCC system_header
#include_next <arm_neon.h>

#undef __ARM_FEATURE_FMA
#define vfmaq_n_f32(c, a, b) vaddq_f32(c, vmulq_n_f32(a, b))
#define vfmaq_n_f64(c, a, b) vaddq_f64(c, vmulq_n_f64(a, b))
#define vfmaq_laneq_f32(c, a, b, lane) vaddq_f32(c, vmulq_laneq_f32(a, b, lane))
#define vfmaq_laneq_f64(c, a, b, lane) vaddq_f64(c, vmulq_laneq_f64(a, b, lane))
