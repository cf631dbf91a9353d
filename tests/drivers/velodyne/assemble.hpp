#pragma once

#include <vector>

#include "drivers/velodyne/sweep_assembler.hpp"

namespace infuse::velodyne {

/// All sweeps that an assembler makes of these datagrams (any range of elements with `datagram()`),
/// the last one included.
template <class Datagrams>
std::vector<Sweep> assemble(SweepAssembler& assembler, const Datagrams& datagrams) {
  std::vector<Sweep> sweeps;
  Sweep sweep;
  const auto drain = [&] {
    while (assembler.pull(sweep)) {
      sweeps.push_back(std::move(sweep));
      sweep = Sweep();
    }
  };
  for (const auto& captured : datagrams) {
    assembler.push(captured.datagram());
    drain();
  }
  assembler.finish();
  drain();
  return sweeps;
}

}  // namespace infuse::velodyne
