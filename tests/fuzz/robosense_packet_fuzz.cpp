// Packets of a RoboSense lidar: the first byte chooses the model and the cut; then come packets of
// 1248 bytes, data and information packets, and a shorter one at the end.

#include <algorithm>
#include <cstdint>
#include <span>

#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/robosense/decoder.hpp"
#include "drivers/robosense/robosense_maker.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse;
  using namespace infuse::robosense;
  if (size < 1) return 0;
  const Model model = models()[data[0] % models().size()].model;
  Decoder decoder({.model = &lidar_model(model), .cut_azimuth = static_cast<double>(data[0])});
  const auto inference = maker().make_inference();
  Sweep sweep;
  std::span<const uint8_t> rest(data + 1, size - 1);
  Stamp stamp = Stamp::from_ns(1'700'000'000'000'000'000);
  while (!rest.empty()) {
    const auto payload = rest.first(std::min(rest.size(), kPacketSize));
    inference->add(payload);
    static_cast<void>(maker().find_packet(rest));
    static_cast<void>(maker().first_azimuth(payload));
    static_cast<void>(maker().read_fix({stamp, 1, 6699, 6699, payload}));
    decoder.push({stamp, 1, 6699, 6699, payload});
    while (decoder.pull(sweep)) {
    }
    stamp += Duration(700'000);
    rest = rest.subspan(payload.size());
  }
  static_cast<void>(inference->infer());
  static_cast<void>(inference->describe());
  static_cast<void>(decoder.streamed_calibration());
  decoder.finish();
  while (decoder.pull(sweep)) {
  }
  return 0;
}
