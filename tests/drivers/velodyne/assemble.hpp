#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

namespace infuse::velodyne {

/// A calibration as the decoder's options carry it.
inline std::shared_ptr<const lidar::UnitCalibration> share(
    const std::optional<Calibration>& calibration) {
  return calibration ? std::make_shared<UnitCalibration>(*calibration) : nullptr;
}

/// All sweeps that a decoder makes of these datagrams (any range of elements with `datagram()`),
/// the last one included.
template <class Datagrams>
std::vector<Sweep> assemble(Decoder& decoder, const Datagrams& datagrams) {
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

}  // namespace infuse::velodyne
