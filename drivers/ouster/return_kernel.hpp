#pragma once

#include <cstdint>
#include <span>

#include "drivers/lidar/return_arrays.hpp"
#include "drivers/measurement/instruction_set.hpp"
#include "drivers/ouster/beam_table.hpp"
#include "drivers/ouster/profile.hpp"

namespace infuse::ouster {

/// A valid column of a packet, and its place in the sweep.
struct ColumnPixels {
  const uint8_t* pixels = nullptr;
  uint16_t measurement_id = 0;
  uint16_t column = 0;         ///< in the sweep
  int32_t time_offset_ns = 0;  ///< after the sweep's first firing
};

/// Appends the returns (range not 0) of the columns to the `size` existing ones, and returns the
/// new size. Writes up to `lidar::kReturnSlack` entries beyond. Of two returns, a
/// second one that is farther than the strongest is the last; else the strongest is both.
using ReturnKernel = size_t (*)(const BeamTable& table, std::span<const ColumnPixels> columns,
                                FirstReturn first_return, const lidar::ReturnArrays& out,
                                size_t size);

/// The kernel of a profile for an instruction set, which the processor must support. All sets give
/// the same bytes.
ReturnKernel return_kernel(Profile profile, InstructionSet set);

}  // namespace infuse::ouster
