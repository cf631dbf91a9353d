#pragma once

#include <vector>

#include "drivers/lidar/lidar_decoder.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::lidar {

/// All sweeps that a decoder makes of these datagrams (any range of elements with `datagram()`),
/// the last one included.
template <class Datagrams>
std::vector<Sweep> assemble(lidar::LidarDecoder& decoder, const Datagrams& datagrams) {
  std::vector<Sweep> sweeps;
  Sweep sweep;
  const auto drain = [&] {
    while (decoder.pull(sweep)) {
      sweeps.push_back(std::move(sweep));
      sweep = Sweep();
    }
  };
  for (const auto& captured : datagrams) {
    decoder.push(captured.datagram());
    drain();
  }
  decoder.finish();
  drain();
  return sweeps;
}

}  // namespace infuse::lidar
