#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "drivers/hesai/firing_times.hpp"
#include "drivers/measurement/datagram.hpp"
#include "tests/drivers/hesai/made_packet.hpp"

namespace infuse::hesai {

/// A packet as received from the network.
struct SentPacket {
  Stamp stamp;
  std::vector<uint8_t> payload;
  uint16_t port = 2368;

  Datagram datagram() const { return {stamp, 0x0A000007, 10'000, port, payload}; }
};

/// Packets of a lidar that turns ten times a second and sees random ranges; every fourth direction
/// has none, every third pair of returns is one.
inline std::vector<SentPacket> make_turns(Model model, ReturnMode mode, double turns,
                                          bool has_number = true) {
  const ModelInfo& info = model_info(model);
  const int count = blocks_of(model) / returns_of(mode);
  const double period_us = static_cast<double>(info.period.count()) * 1e-3;
  const auto packets = static_cast<size_t>(turns * 1e5 / (period_us * count));
  std::mt19937 random(1);
  std::vector<SentPacket> sent;
  for (size_t k = 0; k < packets; ++k) {
    const double start_us = period_us * count * static_cast<double>(k);
    MadePacket made{.model = model, .mode = mode, .number = static_cast<uint32_t>(7'000 + k)};
    for (int i = 0; i < count; ++i) {
      const double degrees = 350 + 0.0036 * (start_us + period_us * i);
      made.azimuths.push_back(static_cast<uint16_t>(std::lround(degrees * 100) % 36'000));
    }
    made.microseconds = static_cast<uint32_t>(std::lround(500 + start_us));
    made.has_number = has_number;
    made.mode_flag = static_cast<uint8_t>(count == 1 ? 1 + k % 2 : 1);
    std::vector<MadeUnit> previous(kMaxLasers);
    made.unit = [&](size_t block, size_t channel) {
      const bool silent =
          model == Model::kQt128 &&
          channel / 32 == (count == 1 ? k % 2 : block);  // a bank that does not fire
      MadeUnit unit{static_cast<uint16_t>(random() % 4 == 0 || silent ? 0 : 1 + random() % 65'535),
                    static_cast<uint8_t>(random())};
      const bool repeats = block % static_cast<size_t>(returns_of(mode)) != 0;
      if (repeats && random() % 3 == 0) unit = previous[channel];
      previous[channel] = unit;
      return unit;
    };
    sent.push_back({Stamp::from_ns(1'700'000'000'000'000'000 +
                                   std::llround(1e3 * (start_us + period_us * count + 60))),
                    make_packet(made)});
  }
  return sent;
}

}  // namespace infuse::hesai
