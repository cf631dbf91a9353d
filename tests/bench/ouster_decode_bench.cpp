// Decodes packets of an OS1-64 in memory to complete sweeps, on one core, and compares with a plain
// decoder on the same packets: point by point, by the published formula, into a vector of points.

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "drivers/ouster/turn_assembler.hpp"
#include "tests/drivers/ouster/made_metadata.hpp"
#include "tests/drivers/ouster/made_packet.hpp"

namespace infuse::ouster {
namespace {

/// A few turns of an OS1-64, nine directions of ten with a return.
struct OusterTurns {
  Metadata metadata = parse_metadata(made_metadata({}), "made metadata").value();
  std::vector<std::vector<uint8_t>> packets;
  std::vector<Stamp> stamps;
  int64_t returns = 0;

  OusterTurns() {
    std::mt19937 random(1);
    for (int64_t column = 0; column < 4 * 1024; column += 16) {
      const int64_t device_ns = 1'000'000'000 + column * 97'656;
      packets.push_back(made_packet(
          metadata, {.frame_id = static_cast<uint32_t>(column / 1024),
                     .first_measurement_id = static_cast<uint16_t>(column % 1024),
                     .device_ns = device_ns,
                     .pixel = [&](uint16_t, size_t) {
                       if (random() % 10 == 0) return MadePixel{};
                       ++returns;
                       return MadePixel{1000 + static_cast<uint32_t>(random()) % 100'000, 0,
                                        static_cast<uint8_t>(random()), 0, 0};
                     }}));
      stamps.push_back(Stamp::from_ns(1'700'000'000'000'000'000 + device_ns));
    }
  }
};

/// Decodes the packets to sweeps.
void run_ouster(benchmark::State& state, const OusterTurns& input) {
  ClockModelOptions clock;
  clock.modulo = Duration::zero();
  lidar::PacketCounters counters;
  lidar::Losses losses(counters);
  std::optional<TurnAssembler> assembler;
  Sweep sweep;
  size_t decoded = 0;
  for ([[maybe_unused]] auto _ : state) {
    state.PauseTiming();  // tables are made when a sensor starts
    assembler.emplace(input.metadata, lidar::DecoderOptions{.cut_azimuth = 180}, clock, counters,
                      losses);
    state.ResumeTiming();
    for (size_t i = 0; i < input.packets.size(); ++i) {
      assembler->push({input.stamps[i], 1, 7502, 7502, input.packets[i]}, {});
      while (assembler->pull(sweep)) decoded += sweep.size();
    }
    assembler->finish();
    while (assembler->pull(sweep)) decoded += sweep.size();
  }
  if (decoded != static_cast<size_t>(input.returns) * state.iterations()) {
    state.SkipWithError("not every return was decoded");
  }
  state.SetItemsProcessed(input.returns * static_cast<int64_t>(state.iterations()));
}

/// A point as a plain driver keeps it.
struct PlainPoint {
  float x, y, z, intensity;
  uint32_t t;
  uint16_t ring;
};

/// Decodes the packets point by point, with the published formula.
void run_plain_ouster(benchmark::State& state, const OusterTurns& input) {
  const Metadata& metadata = input.metadata;
  const double n = metadata.T_lidar_beam.translation().x();
  std::vector<PlainPoint> cloud;
  size_t decoded = 0;
  for ([[maybe_unused]] auto _ : state) {
    for (const std::vector<uint8_t>& packet : input.packets) {
      for (size_t i = 0; i < 16; ++i) {
        const uint8_t* column = packet.data() + 32 + i * (12 + 64 * 12);
        uint64_t time = 0;
        uint16_t id = 0;
        std::memcpy(&time, column, 8);
        std::memcpy(&id, column + 8, 2);
        if (id == 0) {
          decoded += cloud.size();
          cloud.clear();
        }
        const double encoder = 2 * std::numbers::pi * (1 - id / 1024.0);
        for (size_t beam = 0; beam < 64; ++beam) {
          uint32_t range = 0;
          std::memcpy(&range, column + 12 + 12 * beam, 4);
          range &= 0x7FFFF;
          if (range == 0) continue;
          const double r = range / 1000.0 - n;
          const double azimuth = encoder - metadata.azimuth[beam];
          const double elevation = metadata.elevation[beam];
          const Eigen::Vector3d point =
              metadata.T_sensor_lidar *
              Eigen::Vector3d(r * std::cos(azimuth) * std::cos(elevation) + n * std::cos(encoder),
                              r * std::sin(azimuth) * std::cos(elevation) + n * std::sin(encoder),
                              r * std::sin(elevation));
          cloud.push_back({static_cast<float>(point.x()), static_cast<float>(point.y()),
                           static_cast<float>(point.z()),
                           static_cast<float>(column[12 + 12 * beam + 4]),
                           static_cast<uint32_t>(time), static_cast<uint16_t>(63 - beam)});
        }
      }
    }
  }
  benchmark::DoNotOptimize(decoded);
  state.SetItemsProcessed(input.returns * static_cast<int64_t>(state.iterations()));
}

void register_all() {
  static const OusterTurns input;
  benchmark::RegisterBenchmark("decode/OS1-64/single",
                               [](benchmark::State& state) { run_ouster(state, input); });
  benchmark::RegisterBenchmark("decode/OS1-64/single/baseline:plain",
                               [](benchmark::State& state) { run_plain_ouster(state, input); });
}

[[maybe_unused]] const bool registered = (register_all(), true);

}  // namespace
}  // namespace infuse::ouster
