// Data packets of every model: the first byte chooses it, then come packets of 1206 bytes and a
// shorter one at the end.

#include <algorithm>
#include <cstdint>
#include <span>

#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/model_inference.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse;
  using namespace infuse::velodyne;
  if (size == 0) return 0;
  Decoder decoder({.model = &lidar_model(models()[data[0] % models().size()].model),
                   .cut_azimuth = static_cast<double>(data[0])});
  ModelInference inference;
  Sweep sweep;
  std::span<const uint8_t> rest(data + 1, size - 1);
  Stamp stamp = Stamp::from_ns(1'700'000'000'000'000'000);
  while (!rest.empty()) {
    const auto payload = rest.first(std::min(rest.size(), kPacketSize));
    inference.add(payload);
    decoder.push({stamp, 1, 2368, 2368, payload});
    while (decoder.pull(sweep)) {
    }
    stamp += Duration(500'000);
    rest = rest.subspan(payload.size());
  }
  static_cast<void>(inference.infer());
  static_cast<void>(inference.describe());
  decoder.finish();
  while (decoder.pull(sweep)) {
  }
  return 0;
}
