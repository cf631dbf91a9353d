// Decodes packets of an RS-Helios in memory to complete sweeps, on one core, and compares with a
// plain decoder on the same packets: point by point, with the sine and cosine of each azimuth, into
// a vector of points. A return is an entry with a distance.

#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "drivers/lidar/azimuth.hpp"
#include "drivers/measurement/big_endian.hpp"
#include "drivers/robosense/decoder.hpp"
#include "drivers/robosense/robosense_maker.hpp"
#include "tests/drivers/robosense/made_packet.hpp"

namespace infuse::robosense {
namespace {

constexpr double kTurns = 2;  // whose packets stay in the processor's cache, as received ones do

struct PlainPoint {
  float x, y, z, range, intensity;
  uint16_t ring;
  int64_t time_ns;
};

/// Appends the points of a packet of one return; a new cloud begins where the azimuth wraps.
void decode_plainly(const BeamTable& table, const std::vector<uint8_t>& bytes,
                    std::vector<PlainPoint>& cloud, int& last_azimuth) {
  const auto packet = parse_packet(bytes);
  if (!packet) return;
  constexpr double kTurnedPerNs = 0.36e-3 * lidar::kCentidegree;  // at ten turns a second
  for (size_t block = 0; block < kBlocks; ++block) {
    const size_t at = kHeaderSize + block * kBlockSize;
    if (packet->azimuth[block] < last_azimuth) cloud.clear();
    last_azimuth = packet->azimuth[block];
    for (size_t channel = 0; channel < kChannels; ++channel) {
      const size_t unit = at + kBlockPrefix + channel * kUnitSize;
      const int distance = big_endian::read_u16(bytes, unit);
      if (distance == 0) continue;
      const BeamAngles& beam = table.calibration().beams[channel];
      const double range = distance * 0.0025, elevation = beam.elevation * lidar::kCentidegree;
      const double rotor =
          packet->azimuth[block] * lidar::kCentidegree + kTurnedPerNs * table.time_ns()[channel];
      const double azimuth = rotor + beam.azimuth_offset * lidar::kCentidegree;
      const double flat = range * std::cos(elevation);
      const double x = flat * std::cos(azimuth) + table.info().origin_m * std::cos(rotor);
      const double y = -flat * std::sin(azimuth) - table.info().origin_m * std::sin(rotor);
      cloud.push_back({static_cast<float>(x), static_cast<float>(y),
                       static_cast<float>(range * std::sin(elevation)), static_cast<float>(range),
                       static_cast<float>(bytes[unit + 2]) / 255.0F,
                       static_cast<uint16_t>(table.ring()[channel]),
                       packet->time_ns + table.time_ns()[channel]});
    }
  }
}

void run_ours(benchmark::State& state, const std::vector<SentPacket>& packets) {
  Decoder decoder({.model = &lidar_model(Model::kHelios)});
  Sweep sweep;
  int64_t returns = 0;
  for ([[maybe_unused]] auto _ : state) {
    for (const SentPacket& packet : packets) {
      decoder.push(packet.datagram());
      while (decoder.pull(sweep)) {
        returns += static_cast<int64_t>(sweep.size());
        benchmark::DoNotOptimize(sweep.x.data());
      }
    }
  }
  state.SetItemsProcessed(returns);
}

void run_plain(benchmark::State& state, const std::vector<SentPacket>& packets) {
  const BeamTable table(Model::kHelios, built_in_calibration(Model::kHelios), false);
  std::vector<PlainPoint> cloud;
  int last_azimuth = 0;
  int64_t returns = 0;
  for ([[maybe_unused]] auto _ : state) {
    for (const SentPacket& packet : packets) {
      const size_t before = cloud.size();
      decode_plainly(table, packet.payload, cloud, last_azimuth);
      returns += static_cast<int64_t>(cloud.size() - std::min(before, cloud.size()));
      benchmark::DoNotOptimize(cloud.data());
    }
  }
  state.SetItemsProcessed(returns);
}

void register_all() {
  static const std::vector<SentPacket> single = make_turns(32, false, kTurns);
  static const std::vector<SentPacket> dual = make_turns(32, true, kTurns);
  benchmark::RegisterBenchmark("decode/RS-Helios/single",
                               [](benchmark::State& state) { run_ours(state, single); });
  benchmark::RegisterBenchmark("decode/RS-Helios/single/baseline:plain",
                               [](benchmark::State& state) { run_plain(state, single); });
  benchmark::RegisterBenchmark("decode/RS-Helios/dual",
                               [](benchmark::State& state) { run_ours(state, dual); });
  benchmark::RegisterBenchmark("decode/RS-Helios/dual/baseline:plain",
                               [](benchmark::State& state) { run_plain(state, dual); });
}

[[maybe_unused]] const bool registered = (register_all(), true);

}  // namespace
}  // namespace infuse::robosense
