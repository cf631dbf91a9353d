#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <tuple>
#include <vector>

#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/sweep.hpp"
#include "drivers/velodyne/calibration.hpp"
#include "fixtures/velodyne/packet_encoder.hpp"

namespace infuse::velodyne {

/// A packet as received from the network.
struct SentPacket {
  Stamp stamp;
  std::vector<uint8_t> payload;

  Datagram datagram() const { return {stamp, 0x0A000007, 2368, 2368, payload}; }
};

/// Expected return: plain formulas in double precision.
struct ExpectedReturn {
  double x, y, z, range, reflectivity;
  int64_t time_ns;      ///< device time
  double true_azimuth;  ///< °, of the beam at its actual rotation, before any rounding
  double azimuth;       ///< °, with the resolution of packets
};

/// By firing (from the sweep's first), ring and kind.
using ExpectedSweep = std::map<std::tuple<uint32_t, uint16_t, ReturnKind>, ExpectedReturn>;

/// A sensor that turns steadily and measures random ranges, and the expected result of decoding.
struct Scene {
  std::vector<SentPacket> packets;
  std::vector<ExpectedSweep> sweeps;
  std::vector<int64_t> starts_ns;  ///< device time of each sweep's first firing
};

/// Options of a scene.
struct SceneOptions {
  Model model = Model::kHdl32e;
  ReturnMode mode = ReturnMode::kStrongest;
  double turns_per_second = 10;
  double start_azimuth = 350;  ///< °
  double turns = 1.2;
  uint32_t start_us = 0;
  int64_t host_ns = 1'700'000'000'000'000'000;
  Calibration calibration{};
  double cycle_us = 0;  ///< firing cycle, if it is not the model's
  unsigned seed = 1;
};

/// Firing time of a laser after its sequence's start, µs: the manuals' tables.
inline double manual_time_us(Model model, size_t slot, double cycle_us) {
  const auto j = static_cast<double>(slot);
  switch (model) {
    case Model::kHdl32e:
      return 1.152 * j;
    case Model::kVlp16:
    case Model::kPuckHiRes:
      return slot < 16 ? 2.304 * j : 55.296 + 2.304 * (j - 16);
    case Model::kVlp32c:
      return 2.304 * std::floor(j / 2);
    case Model::kHdl64eS2: {
      const double within[]{0, 1.26, 2.46, 3.66};
      return 6.0 * static_cast<double>(slot % 32 / 4) + within[slot % 4];
    }
    case Model::kHdl64eS3: {
      const double within[]{0, 1.3, 2.5, 3.7};
      return 7.2 * static_cast<double>(slot % 32 / 4) + within[slot % 4];
    }
    case Model::kVls128:
      return cycle_us / 20 * static_cast<double>(slot / 8 + (slot / 64));
  }
  return 0;
}

/// Position of one return of an HDL-64E in vendor axes (x right, y forward, z up), by the vendor's
/// formulas.
inline std::array<double, 3> hdl64e_position(const BeamCorrection& c, double d, double theta) {
  const double far = c.distance;
  double cx = far;
  double cy = far;
  const double cos_phi = std::cos(c.elevation);
  if (d < 25.04) {
    const double xx = std::abs((d + far) * cos_phi * std::sin(theta));
    const double yy = std::abs((d + far) * cos_phi * std::cos(theta));
    cx = c.distance_x + (far - c.distance_x) * (xx - 2.40) / (25.04 - 2.40);
    cy = c.distance_y + (far - c.distance_y) * (yy - 1.93) / (25.04 - 1.93);
  }
  return {(d + cx) * cos_phi * std::sin(theta) - c.horizontal_offset * std::cos(theta),
          (d + cy) * cos_phi * std::cos(theta) + c.horizontal_offset * std::sin(theta),
          (d + (cx + cy) / 2) * std::sin(c.elevation) + c.vertical_offset};
}

/// Reflectivity 0 … 1 of an HDL-64E, by the vendor's formula.
inline double hdl64e_reflectivity(const BeamCorrection& c, double raw_distance, double raw) {
  const double corrected = raw + 256 * c.focal_slope *
                                     std::abs(std::pow(1 - c.focal_distance / 131, 2) -
                                              std::pow(1 - raw_distance / 65535, 2));
  return std::clamp(corrected, c.min_intensity, c.max_intensity) / 255;
}

/// Makes a scene.
inline Scene make_scene(const SceneOptions& options) {
  const ModelInfo& info = model_info(options.model);
  const Calibration& calibration = options.calibration;
  const double cycle_us =
      options.cycle_us > 0 ? options.cycle_us : static_cast<double>(info.cycle.count()) * 1e-3;
  const double period_us = cycle_us * info.firings;
  const bool dual = options.mode == ReturnMode::kDual;
  const auto degrees_at = [&](double us) {
    return options.start_azimuth + options.turns_per_second * 360 * us * 1e-6;
  };
  const auto hundredths_at = [&](size_t i) {
    return static_cast<int64_t>(degrees_at(static_cast<double>(i) * period_us) * 100);
  };
  const auto rings = calibration.rings(info);
  const double unit = info.distance_unit_mm * 1e-3;

  std::mt19937 random(options.seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto echo = [&](size_t slot) {
    const double beyond = calibration.beams[slot % info.lasers].distance;
    return fixtures::Echo{uniform(random) < 0.1 ? 0 : beyond + 0.9 + 100 * uniform(random),
                          static_cast<uint8_t>(255 * uniform(random))};
  };

  Scene scene;
  PacketEncoder encoder({.model = options.model, .mode = options.mode, .calibration = calibration});
  const auto per_packet = info.sequences_per_packet(dual);
  const auto count =
      static_cast<size_t>(options.turns / options.turns_per_second * 1e6 / period_us);
  size_t first_of_sweep = 0;
  uint32_t counter_us = 0;
  for (size_t i = 0; i < count / per_packet * per_packet; ++i) {
    if (i % per_packet == 0) {
      counter_us = static_cast<uint32_t>(
          (options.start_us + static_cast<int64_t>(static_cast<double>(i) * period_us)) %
          3'600'000'000);
    }
    const int64_t now = hundredths_at(i);
    const int64_t next = hundredths_at(i + 1);
    if (i == 0 || now / 36'000 != hundredths_at(i - 1) / 36'000) {
      scene.sweeps.emplace_back();
      scene.starts_ns.push_back(counter_us * int64_t{1000} +
                                std::lround(static_cast<double>(i % per_packet) * period_us * 1e3));
      first_of_sweep = i;
    }
    std::vector<fixtures::Echo> strongest(info.slots());
    std::vector<fixtures::Echo> last(info.slots());
    for (size_t slot = 0; slot < info.slots(); ++slot) {
      strongest[slot] = echo(slot);
      last[slot] = uniform(random) < 0.5 ? strongest[slot] : echo(slot);
      const auto expect = [&](const fixtures::Echo& e, ReturnKind kind) {
        if (e.range == 0) return;
        const BeamCorrection& c = calibration.beams[slot % info.lasers];
        const double raw = std::round((e.range - c.distance) / unit);
        const double us = manual_time_us(options.model, slot, cycle_us);
        const double azimuth =
            static_cast<double>(now) + static_cast<double>(next - now) * us / period_us;  // 0.01°
        const double theta = azimuth * std::numbers::pi / 18'000 - c.rotation;
        ExpectedReturn r{};
        r.range = raw * unit + c.distance;
        r.reflectivity = e.reflectivity / 255.0;
        std::array<double, 3> vendor{r.range * std::cos(c.elevation) * std::sin(theta),
                                     r.range * std::cos(c.elevation) * std::cos(theta),
                                     r.range * std::sin(c.elevation) + c.vertical_offset};
        if (info.calibrated_per_unit) {
          vendor = hdl64e_position(c, raw * unit, theta);
          r.reflectivity = hdl64e_reflectivity(c, raw, e.reflectivity);
        }
        r.x = vendor[1];
        r.y = -vendor[0];
        r.z = vendor[2];
        r.azimuth = azimuth / 100;
        r.true_azimuth = degrees_at(static_cast<double>(i) * period_us + us);
        r.time_ns = counter_us * int64_t{1000} +
                    std::lround(static_cast<double>(i % per_packet) * period_us * 1e3) +
                    std::lround(us * 1e3);
        const auto column =
            static_cast<uint32_t>((i - first_of_sweep) * info.firings + slot / info.lasers);
        scene.sweeps.back()[{column, rings[slot % info.lasers], kind}] = r;
      };
      const bool same =
          std::lround(strongest[slot].range / unit) == std::lround(last[slot].range / unit) &&
          strongest[slot].reflectivity == last[slot].reflectivity;
      if (dual && same) {
        expect(strongest[slot], ReturnKind::kBoth);
      } else if (dual) {
        expect(strongest[slot], ReturnKind::kStrongest);
        expect(last[slot], ReturnKind::kLast);
      } else {
        expect(strongest[slot],
               options.mode == ReturnMode::kLast ? ReturnKind::kLast : ReturnKind::kStrongest);
      }
    }
    if (encoder.add_sequence(static_cast<uint16_t>(now % 36'000), counter_us, strongest, last)) {
      const double sent_us = static_cast<double>(i + 1) * period_us + 40;
      scene.packets.push_back({Stamp::from_ns(options.host_ns) + from_seconds(sent_us * 1e-6),
                               {encoder.packet().begin(), encoder.packet().end()}});
    }
  }
  return scene;
}

}  // namespace infuse::velodyne
