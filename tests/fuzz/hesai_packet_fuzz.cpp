// Data packets of every model: the first byte chooses it, the second sets how many bytes a packet
// has more or less than the model's; then come packets, and a shorter one at the end. Each is also
// read as a GPS packet, and the whole as an angle correction file.

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>

#include "drivers/hesai/calibration_file.hpp"
#include "drivers/hesai/decoder.hpp"
#include "drivers/hesai/gps_packet.hpp"
#include "drivers/hesai/hesai_maker.hpp"
#include "drivers/lidar/lidar_maker.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse;
  using namespace infuse::hesai;
  if (size < 2) return 0;
  const ModelInfo& info = models()[data[0] % models().size()];
  const size_t packet_size = info.body_end() + info.tail.size + data[1];
  Decoder decoder({.model = &lidar_model(info.model), .cut_azimuth = static_cast<double>(data[0])});
  const auto inference = maker().make_inference();
  Sweep sweep;
  std::span<const uint8_t> rest(data + 2, size - 2);
  static_cast<void>(parse_angle_csv(
      std::string_view(reinterpret_cast<const char*>(rest.data()), rest.size()), info));
  static_cast<void>(parse_gps_packet(rest.first(std::min(rest.size(), kGpsPacketSize))));
  Stamp stamp = Stamp::from_ns(1'700'000'000'000'000'000);
  while (!rest.empty()) {
    const auto payload = rest.first(std::min(rest.size(), packet_size));
    inference->add(payload);
    decoder.push({stamp, 1, 2368, 2368, payload});
    while (decoder.pull(sweep)) {
    }
    stamp += Duration(500'000);
    rest = rest.subspan(payload.size());
  }
  static_cast<void>(inference->infer());
  static_cast<void>(inference->describe());
  decoder.finish();
  while (decoder.pull(sweep)) {
  }
  return 0;
}
