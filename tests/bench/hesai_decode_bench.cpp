// Decodes packets of Hesai lidars in memory to complete sweeps, on one core, and compares with a
// plain decoder on the same packets: point by point, with the sine and cosine of each azimuth, into
// a vector of points. A return is an entry with a distance.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "drivers/hesai/decoder.hpp"
#include "drivers/hesai/hesai_maker.hpp"
#include "drivers/lidar/little_endian.hpp"
#include "tests/drivers/hesai/made_turns.hpp"

namespace infuse::hesai {
namespace {

constexpr double kTurns = 2;  // whose packets stay in the processor's cache, as received ones do

struct Scene {
  Model model;
  ReturnMode mode;
  std::vector<SentPacket> packets = make_turns(model, mode, kTurns);
};

struct PlainPoint {
  float x, y, z, range, intensity;
  uint16_t ring;
  int64_t time_ns;
};

/// What a plain decoder prepares: angles and times of the channels.
struct PlainChannel {
  double cos_elevation, sin_elevation, offset, time_ns;
  uint16_t ring;
};

std::vector<PlainChannel> plain_channels(Model model) {
  const Calibration& calibration = built_in_calibration(model);
  const auto rings = calibration.rings(model_info(model));
  const FiringTimes times = firing_times(model, 0);
  std::vector<PlainChannel> channels;
  for (size_t i = 0; i < model_info(model).lasers; ++i) {
    const BeamAngles& beam = calibration.beams[i];
    channels.push_back({std::cos(beam.elevation), std::sin(beam.elevation), beam.azimuth_offset,
                        static_cast<double>(times.channel_ns[i]), rings[i]});
  }
  return channels;
}

/// Appends the points of a packet; a new cloud begins where the azimuth wraps.
void decode_plainly(const ModelInfo& info, const std::vector<PlainChannel>& channels,
                    const std::vector<uint8_t>& bytes, std::vector<PlainPoint>& cloud,
                    int& last_azimuth) {
  const auto packet = parse_packet(info, bytes);
  if (!packet) return;
  const double turned_per_ns = packet->motor_speed * 2 * std::numbers::pi / 60e9;
  for (size_t block = 0; block < info.blocks; ++block) {
    const uint8_t* at = bytes.data() + info.header_size + block * info.block_size();
    const int raw_azimuth = lidar::read_u16(at + info.block_prefix - 2);
    if (raw_azimuth < last_azimuth) cloud.clear();
    last_azimuth = raw_azimuth;
    const int64_t block_ns = block_time_ns(info.model, *packet, block / packet->returns);
    for (size_t channel = 0; channel < info.lasers; ++channel) {
      const uint8_t* unit = at + info.block_prefix + channel * info.unit_size;
      const int distance = lidar::read_u16(unit);
      if (distance == 0) continue;
      const PlainChannel& of = channels[channel];
      const double range = distance * 0.004;
      const double azimuth =
          raw_azimuth * std::numbers::pi / 18'000 + of.offset + turned_per_ns * of.time_ns;
      const double horizontal = range * of.cos_elevation;
      cloud.push_back({static_cast<float>(horizontal * std::cos(azimuth)),
                       static_cast<float>(-horizontal * std::sin(azimuth)),
                       static_cast<float>(range * of.sin_elevation), static_cast<float>(range),
                       static_cast<float>(unit[2]) / 255.0F, of.ring,
                       packet->utc_ns + block_ns + static_cast<int64_t>(of.time_ns)});
    }
  }
}

void run_ours(benchmark::State& state, const Scene& scene) {
  Decoder decoder({.model = &lidar_model(scene.model)});
  Sweep sweep;
  int64_t returns = 0;
  for ([[maybe_unused]] auto _ : state) {
    for (const SentPacket& packet : scene.packets) {
      decoder.push(packet.datagram());
      while (decoder.pull(sweep)) {
        returns += static_cast<int64_t>(sweep.size());
        benchmark::DoNotOptimize(sweep.x.data());
      }
    }
  }
  state.SetItemsProcessed(returns);
}

void run_plain(benchmark::State& state, const Scene& scene) {
  const auto channels = plain_channels(scene.model);
  std::vector<PlainPoint> cloud;
  int last_azimuth = 0;
  int64_t returns = 0;
  for ([[maybe_unused]] auto _ : state) {
    for (const SentPacket& packet : scene.packets) {
      const size_t before = cloud.size();
      decode_plainly(model_info(scene.model), channels, packet.payload, cloud, last_azimuth);
      returns += static_cast<int64_t>(cloud.size() - std::min(before, cloud.size()));
      benchmark::DoNotOptimize(cloud.data());
    }
  }
  state.SetItemsProcessed(returns);
}

void register_all() {
  static const Scene scenes[]{{Model::kXt32, ReturnMode::kStrongest},
                              {Model::kXt32, ReturnMode::kLastStrongest},
                              {Model::kPandar40p, ReturnMode::kLastStrongest},
                              {Model::kQt128, ReturnMode::kStrongest}};
  for (const Scene& scene : scenes) {
    const std::string name = std::string("decode/") + model_info(scene.model).name + "/" +
                             (number_of_returns(scene.mode) > 1 ? "dual" : "single");
    benchmark::RegisterBenchmark(name.c_str(),
                                 [&scene](benchmark::State& state) { run_ours(state, scene); });
    benchmark::RegisterBenchmark((name + "/baseline:plain").c_str(),
                                 [&scene](benchmark::State& state) { run_plain(state, scene); });
  }
}

[[maybe_unused]] const bool registered = (register_all(), true);

}  // namespace
}  // namespace infuse::hesai
