#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/lidar/return_arrays.hpp"
#include "drivers/measurement/instruction_set.hpp"
#include "drivers/robosense/beam_table.hpp"

namespace infuse::robosense {

/// One firing of all channels as the kernel reads it.
struct Firing {
  const uint8_t* units = nullptr;  ///< of its first return
  BeamTable::Row row{};            ///< directions of the slots
  size_t slot = 0;                 ///< of its first channel
  float cos_azimuth = 1;           ///< of the block's azimuth, clockwise from forward
  float sin_azimuth = 0;
  uint16_t column = 0;
  int32_t time_offset_ns = 0;  ///< of the sequence's start, after the sweep's first firing
};

/// What the firings of a packet share.
struct UnitLayout {
  uint8_t returns = 1;         ///< of one firing: 1 or 2
  uint32_t return_stride = 0;  ///< bytes from the units of the first return to those of the second
  float distance_unit = 0;     ///< m
  std::array<ReturnKind, 2> kinds{};
};

/// Appends the returns (distance not 0) of the firings to the `size` existing ones, and returns the
/// new size. Returns of one pulse that are equal in distance and reflectivity become one of kind
/// `kBoth`. Coordinates are in the lidar frame.
using ReturnKernel = size_t (*)(const BeamTable& table, std::span<const Firing> firings,
                                const UnitLayout& layout, const lidar::ReturnArrays& out,
                                size_t size);

/// The kernel for an instruction set, which the processor must support. All give the same bytes.
ReturnKernel return_kernel(InstructionSet set);

}  // namespace infuse::robosense
