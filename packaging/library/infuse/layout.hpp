#pragma once

/// @file
/// What a program must have in common with the library.

#include <Eigen/Core>

// Eigen aligns its matrices to the registers of the processor that a file is compiled for, so that
// one size of them would have two layouts in a program.
static_assert(EIGEN_MAX_ALIGN_BYTES == 16,
              "infuse is compiled for any processor: without -march=native and -mavx, or with "
              "-DEIGEN_MAX_ALIGN_BYTES=16 for all of your program");
