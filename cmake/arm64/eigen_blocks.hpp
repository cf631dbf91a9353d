// Included by Eigen after its packets of NEON and before its products of matrices: see arm_neon.h.
#undef EIGEN_HAS_SINGLE_INSTRUCTION_MADD
