#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <ctime>
#include <map>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "drivers/lidar/lidar_decoder.hpp"
#include "drivers/measurement/sweep.hpp"
#include "tests/drivers/robosense/made_packet.hpp"

namespace infuse::robosense {

/// Elevation and azimuth offset of each channel, °.
using PlainAngles = std::vector<std::pair<double, double>>;

/// One return as a plain decoder computes it: byte by byte, in double precision, from the manual's
/// layouts and formulas.
struct PlainReturn {
  int channel = 0;
  int distance = 0;      ///< as on the wire
  int reflectivity = 0;  ///< 0 … 255
  double rotor = 0;      ///< °, azimuth of the rotor at the firing
  int64_t time_ns = 0;   ///< device time
  ReturnKind kind = ReturnKind::kStrongest;
};

/// One firing of all channels: its returns, in the order of channels.
struct PlainFiring {
  int64_t start_ns = 0;  ///< device time of its first channel
  std::vector<PlainReturn> returns;
};

inline int big_endian_16(std::span<const uint8_t> bytes, int at) {
  return bytes[static_cast<size_t>(at)] << 8 | bytes[static_cast<size_t>(at + 1)];
}

inline int64_t plain_time_ns(std::span<const uint8_t> bytes) {
  int64_t seconds = 0, microseconds = 0;
  if (bytes[3] == 0x0A && bytes[32] != 4) {  // RS-Bpearl, version 3: a date
    tm date{};
    date.tm_year = bytes[20] + 100;
    date.tm_mon = bytes[21] - 1;
    date.tm_mday = bytes[22];
    date.tm_hour = bytes[23];
    date.tm_min = bytes[24];
    date.tm_sec = bytes[25];
    return timegm(&date) * 1'000'000'000 + big_endian_16(bytes, 26) * 1'000'000 +
           big_endian_16(bytes, 28) * 1'000;
  }
  for (size_t i = 20; i < 26; ++i) seconds = seconds * 256 + bytes[i];
  for (size_t i = 26; i < 30; ++i) microseconds = microseconds * 256 + bytes[i];
  return seconds * 1'000'000'000 + microseconds * 1'000;
}

/// Firing time of a channel after its block's, µs: the manuals' appendix.
inline double plain_channel_us(PlainModel model, bool dual, int channel) {
  static const double times[]{0,     1.57,  3.15,  4.72,  6.30,  7.87,  9.45,  11.36,
                              13.26, 15.17, 17.08, 18.99, 20.56, 22.14, 23.71, 25.29,
                              26.53, 27.77, 29.01, 30.25, 31.49, 32.73, 33.98, 35.22,
                              36.46, 37.70, 38.94, 40.18, 41.42, 42.67, 43.91, 45.15};
  static const double times16[]{0,     3.15,  6.30,  9.45,  13.26, 17.08, 20.56, 23.71,
                                26.53, 27.77, 31.49, 32.73, 36.46, 38.94, 41.42, 43.91};
  // The manual of RS-Bpearl, A.1, and of its version 4 some values of the maker's table.
  if (model.bpearl == 3) {
    const bool later = (channel >= 8 && channel < 16) || channel >= 24;
    return 2.56 * (channel % 16) + (channel >= 16 ? 1.28 : 0) + (later ? 5.2 : 0);
  }
  static const double times4[]{0,     1.67,  3.34,  5.00,  6.67,  8.34,  10.01, 11.68,
                               13.34, 15.01, 16.68, 18.35, 20.02, 21.68, 23.35, 25.02,
                               26.69, 28.36, 30.02, 31.69, 33.36, 35.03, 36.70, 38.36,
                               40.03, 41.70, 43.37, 45.04, 46.70, 48.37, 50.04, 51.71};
  if (model.bpearl == 4) return times4[channel];
  if (model.lasers == 16) return times16[channel];
  const bool swapped = !dual && (channel == 17 || channel == 21);
  const bool swapped_back = !dual && (channel == 18 || channel == 22);
  return times[swapped ? channel + 1 : swapped_back ? channel - 1 : channel];
}

/// Decodes the payloads of data packets in a row, none of which is missing. `single`: kind of a
/// single return.
inline std::vector<PlainFiring> plain_decode(PlainModel model, bool dual,
                                             const std::vector<std::span<const uint8_t>>& packets,
                                             ReturnKind single = ReturnKind::kStrongest) {
  const int lasers = model.lasers;
  const int step_blocks = dual && lasers == 32 ? 2 : 1;
  const int firings_each = lasers == 16 && !dual ? 2 : 1;
  const double block_us = model.firing_us() * firings_each;
  std::vector<int> azimuths;
  for (const auto& packet : packets) {
    for (int block = 0; block < 12; block += step_blocks) {
      azimuths.push_back(big_endian_16(packet, 44 + 100 * block));
    }
  }
  std::vector<PlainFiring> firings;
  size_t sequence = 0;
  int step = 0;
  for (const auto& packet : packets) {
    for (int block = 0; block < 12; block += step_blocks) {
      if (sequence + 1 < azimuths.size()) {
        step = (azimuths[sequence + 1] - azimuths[sequence] + 36'000) % 36'000;
      }
      const int64_t block_ns =
          plain_time_ns(packet) + std::llround(block / step_blocks * block_us * 1000);
      for (int k = 0; k < firings_each; ++k) {
        PlainFiring firing{block_ns + std::llround(k * 55'556.0), {}};
        for (int channel = 0; channel < lasers; ++channel) {
          const double us = plain_channel_us(model, dual, channel) + k * 55.556;
          int previous = -1;
          for (int echo = 0; echo < (dual ? 2 : 1); ++echo) {
            const int unit = lasers == 16 ? channel + 16 * (k + echo) : channel;
            const int at = 46 + 100 * (lasers == 32 ? block + echo : block) + 3 * unit;
            PlainReturn r{
                channel,
                big_endian_16(packet, at),
                packet[static_cast<size_t>(at + 2)],
                azimuths[sequence] * 0.01 + step * 0.01 * us / block_us,
                block_ns + std::llround(us * 1000),
                dual ? echo == 0 ? ReturnKind::kStrongest : ReturnKind::kSecondStrongest : single};
            const int all = r.distance * 256 + r.reflectivity;
            if (r.distance != 0 && all == previous) {
              firing.returns.back().kind = ReturnKind::kBoth;
            } else if (r.distance != 0) {
              firing.returns.push_back(r);
            }
            previous = all;
          }
        }
        firings.push_back(std::move(firing));
      }
      ++sequence;
    }
  }
  return firings;
}

/// Number of beams whose elevation is below a channel's.
inline int plain_ring(const PlainAngles& angles, int channel) {
  int ring = 0;
  for (const auto& [elevation, azimuth] : angles) {
    ring += elevation < angles[static_cast<size_t>(channel)].first ? 1 : 0;
  }
  return ring;
}

/// Expects the sweeps' returns to be those of the firings, in order of firing: each by ring, range,
/// reflectivity, kind and time exactly, elevation to 1e-4°, azimuth to 1e-3° once the origin of the
/// beam before the axis is taken off. Of a sensor that turns anticlockwise the azimuths are those
/// of its mirror image. Returns their number.
inline size_t expect_equal(const std::vector<Sweep>& sweeps,
                           const std::vector<PlainFiring>& firings, const PlainAngles& angles,
                           PlainModel model = 32, bool anticlockwise = false) {
  const double origin = model.bpearl == 4 ? 0.01619 : model.bpearl == 3 ? 0.01473 : 0.03498;
  const float unit = static_cast<float>(model.unit_m());
  const double side = anticlockwise ? -1 : 1;
  constexpr double kDegree = std::numbers::pi / 180;
  size_t firing = 0, compared = 0;
  for (const Sweep& sweep : sweeps) {
    if (firing >= firings.size()) {
      ADD_FAILURE() << "more sweeps than firings";
      return compared;
    }
    const int64_t start_ns = firings[firing].start_ns;
    std::map<std::pair<int, int>, std::vector<size_t>> by_beam;  // column, ring
    for (size_t i = 0; i < sweep.size(); ++i) {
      by_beam[{sweep.column[i], sweep.ring[i]}].push_back(i);
    }
    size_t found = 0;
    for (uint32_t column = 0; column < sweep.columns && firing < firings.size(); ++column) {
      std::map<int, size_t> taken;  // by ring
      for (const PlainReturn& r : firings[firing++].returns) {
        const int ring = plain_ring(angles, r.channel);
        const auto& candidates = by_beam[{static_cast<int>(column), ring}];
        const size_t at = taken[ring]++;
        if (at >= candidates.size()) {
          ADD_FAILURE() << "no return of channel " << r.channel << " in column " << column;
          return compared;
        }
        const size_t i = candidates[at];
        ++found;
        EXPECT_EQ(sweep.range[i], static_cast<float>(r.distance) * unit);
        EXPECT_EQ(std::lround(sweep.reflectivity[i] * 255), r.reflectivity);
        EXPECT_EQ(sweep.time_offset_ns[i], r.time_ns - start_ns);
        EXPECT_EQ(sweep.return_kind[i], r.kind);
        const double x = sweep.x[i] - origin * std::cos(r.rotor * kDegree);
        const double y = side * sweep.y[i] + origin * std::sin(r.rotor * kDegree);
        const auto& [elevation, offset] = angles[static_cast<size_t>(r.channel)];
        // Of a range below a metre, the rounding of the coordinates is larger than the bound.
        const double rounding = 2e-6 / std::max(r.distance * model.unit_m(), 1e-3);
        EXPECT_NEAR(std::atan2(sweep.z[i], std::hypot(x, y)) / kDegree, elevation, 1e-4 + rounding);
        EXPECT_NEAR(std::remainder(std::atan2(-y, x) / kDegree - r.rotor - offset, 360), 0,
                    1e-3 + rounding);
        EXPECT_NEAR(std::hypot(x, y, sweep.z[i]), r.distance * model.unit_m(), 1e-4);
        if (testing::Test::HasFailure()) return compared;
        ++compared;
      }
    }
    EXPECT_EQ(found, sweep.size());
  }
  EXPECT_EQ(firing, firings.size());
  return compared;
}

/// The payloads of all data packets.
template <class Packets>
std::vector<std::span<const uint8_t>> data_payloads(const Packets& packets) {
  std::vector<std::span<const uint8_t>> payloads;
  for (const auto& packet : packets) {
    if (packet.port == 6699) payloads.emplace_back(packet.payload);
  }
  return payloads;
}

}  // namespace infuse::robosense
