#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/lidar/return_arrays.hpp"
#include "drivers/measurement/instruction_set.hpp"
#include "drivers/velodyne/beam_table.hpp"

namespace infuse::velodyne {

/// One firing sequence as the kernel reads it.
struct SequenceBlocks {
  const uint8_t* returns = nullptr;  ///< first bank's first echo: 32 × 3 bytes
  uint32_t bank_stride = 0;          ///< bytes from one bank to the next
  uint32_t echo_stride = 0;          ///< bytes from one echo to the other; 0 with one return
  float cos_azimuth = 1;             ///< of the sequence's azimuth, clockwise from forward
  float sin_azimuth = 0;
  uint16_t step = 0;           ///< 0.01°; azimuth turned until the next sequence
  uint16_t column = 0;         ///< of the first firing
  int32_t time_offset_ns = 0;  ///< after the sweep's first firing
};

/// Kinds of the first and the second echo in a packet; the second applies with two returns only.
struct EchoKinds {
  ReturnKind first = ReturnKind::kStrongest;
  ReturnKind second = ReturnKind::kLast;
};

using lidar::ReturnArrays;

/// Appends the returns (distance not 0) of the sequences to the `size` existing ones, and returns
/// the new size. With two returns, equal echoes of one pulse become one of kind `kBoth`.
/// Coordinates are in the lidar frame; an HDL-64E's have its full correction.
using ReturnKernel = size_t (*)(const BeamTable& table, std::span<const SequenceBlocks> sequences,
                                EchoKinds kinds, const ReturnArrays& out, size_t size);

/// The kernel for an instruction set, which the processor must support. All give the same bytes.
ReturnKernel return_kernel(InstructionSet set);

}  // namespace infuse::velodyne
