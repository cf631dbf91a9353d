#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/hesai/beam_table.hpp"
#include "drivers/lidar/return_arrays.hpp"
#include "drivers/measurement/instruction_set.hpp"

namespace infuse::hesai {

/// One firing as the kernel reads it.
struct Firing {
  const uint8_t* units = nullptr;    ///< of the first of its blocks
  BeamTable::Row row{};              ///< directions of its channels
  const int32_t* time_ns = nullptr;  ///< firing times of its channels, after `time_offset_ns`
  float cos_azimuth = 1;             ///< of the block's azimuth, clockwise from forward
  float sin_azimuth = 0;
  uint16_t column = 0;
  int32_t time_offset_ns = 0;  ///< of the first channel, after the sweep's first firing
};

/// What the firings of a packet share.
struct UnitLayout {
  uint8_t unit_size = 4;    ///< bytes: 3 or 4
  uint8_t returns = 1;      ///< blocks of one firing: 1, 2 or 3
  uint32_t block_size = 0;  ///< bytes from one block to the next
  float distance_unit = 0;  ///< m
  std::array<ReturnKind, kMaxReturns> kinds{};
};

/// Appends the returns (distance not 0) of the firings to the `size` existing ones, and returns the
/// new size. Returns of one pulse that are equal in distance and reflectivity become one of kind
/// `kBoth`. A unit's fourth byte is not used. Coordinates are in the lidar frame.
using ReturnKernel = size_t (*)(const BeamTable& table, std::span<const Firing> firings,
                                const UnitLayout& layout, const lidar::ReturnArrays& out,
                                size_t size);

/// The kernel for an instruction set, which the processor must support. All give the same bytes.
ReturnKernel return_kernel(InstructionSet set);

}  // namespace infuse::hesai
