// Lidar and inertial packets of an Ouster: the first byte chooses the profile, the second the
// number of beams and the window, then come packets of that layout and a shorter one at the end.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "drivers/ouster/imu_packet.hpp"
#include "drivers/ouster/packet_inference.hpp"
#include "drivers/ouster/turn_assembler.hpp"

namespace {

using namespace infuse;
using namespace infuse::ouster;

/// A sensor without angles: what matters here is the layout.
Metadata sensor(uint8_t profile, uint8_t shape) {
  Metadata metadata;
  metadata.profile = kProfiles[profile % kProfiles.size()].profile;
  metadata.elevation.assign(16, 0.1);
  metadata.azimuth.assign(16, 0.1);
  metadata.columns_per_turn = 512;
  metadata.columns_per_packet = (shape & 1) != 0 ? 16 : 4;
  metadata.window = {0, 511};
  if ((shape & 2) != 0) metadata.window = {100, 122};
  if ((shape & 4) != 0) metadata.window = {500, 20};
  metadata.turns_per_second = (shape & 8) != 0 ? 10 : 0;
  return metadata;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 2) return 0;
  const Metadata metadata = sensor(data[0], data[1]);
  const PacketLayout layout(metadata);
  ClockModelOptions clock;
  clock.modulo = Duration::zero();
  lidar::PacketCounters counters;
  lidar::Losses losses(counters);
  TurnAssembler assembler(metadata, {.cut_azimuth = static_cast<double>(data[1])}, clock, counters,
                          losses);
  PacketInference inference;
  Sweep sweep;
  std::span<const uint8_t> rest(data + 2, size - 2);
  Stamp stamp = Stamp::from_ns(1'700'000'000'000'000'000);
  while (!rest.empty()) {
    const auto payload = rest.first(std::min(rest.size(), layout.packet_bytes()));
    inference.add(payload);
    static_cast<void>(is_imu_packet(payload));
    if (parse_packet(layout, payload)) {
      assembler.push({stamp, 1, 7502, 7502, payload}, {});
    } else {
      assembler.note_refused();
    }
    while (assembler.pull(sweep)) {
    }
    stamp += Duration(1'500'000);
    rest = rest.subspan(payload.size());
  }
  static_cast<void>(inference.describe());
  static_cast<void>(inference.turns_per_second());
  assembler.finish();
  while (assembler.pull(sweep)) {
  }
  return 0;
}
