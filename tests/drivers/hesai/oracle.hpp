#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/hesai/calibration.hpp"
#include "drivers/measurement/sweep.hpp"
#include "tests/drivers/hesai/made_packet.hpp"
#include "tests/drivers/hesai/manual_times.hpp"

namespace infuse::hesai {

/// One return as a plain decoder computes it: byte by byte, in double precision, from the manuals'
/// layouts and formulas.
struct PlainReturn {
  int block = 0, channel = 0;
  int distance = 0;       ///< as on the wire
  int reflectivity = 0;   ///< 0 … 255
  int block_azimuth = 0;  ///< 0.01°
  double azimuth = 0;     ///< °, with the channel's offset and firing time
  double elevation = 0;   ///< °
  int64_t time_ns = 0;    ///< device time
  int returns = 0;        ///< of the mode: number in `echo` 0 … returns − 1
  int echo = 0;
};

/// One firing: its returns, in the order of channels and blocks.
struct PlainFiring {
  int64_t first_ns = 0;  ///< device time of its earliest channel
  std::vector<PlainReturn> returns;
};

/// Where a plain decoder finds things: bytes before the first block, from a block's start to its
/// azimuth, of a unit, of what follows the blocks before the tail.
struct PlainLayout {
  int header, azimuth, unit, mode, speed, date, microseconds;
};

inline PlainLayout plain_layout(Model model, size_t size) {
  switch (model) {
    case Model::kPandar40p:
      return {0, 2, 3, 14, 8, 16, 10};
    case Model::kPandar64:
      return {8, 0, 3, 14, 8, 16, 10};
    case Model::kQt64:
      return {12, 0, 4, 16, 10, 18, 12};
    case Model::kQt128: {
      const int before = size == 1127 || size == 1123 || size == 1095 || size == 1091 ? 21 : 4;
      return {12, 0, 4, before + 12, before + 13, before + 15, before + 21};
    }
    default:
      return {12, 0, 4, 10, 11, 13, 19};
  }
}

/// Seconds since 1970 of a date of the Gregorian calendar and a time of day.
inline int64_t plain_seconds(const uint8_t* date) {
  const int year = date[0] < 100 ? 2000 + date[0] : 1900 + date[0];
  int64_t days = 0;
  const auto leap = [](int y) { return (y % 4 == 0 && y % 100 != 0) || y % 400 == 0; };
  for (int y = 1970; y < year; ++y) days += leap(y) ? 366 : 365;
  const int of_month[]{31, leap(year) ? 29 : 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  for (int m = 1; m < date[1]; ++m) days += of_month[m - 1];
  days += date[2] - 1;
  return ((days * 24 + date[3]) * 60 + date[4]) * 60 + date[5];
}

/// Decodes a packet; `angles`: elevation and azimuth of each channel, °.
inline std::vector<PlainFiring> plain_decode(Model model, std::span<const uint8_t> bytes,
                                             const std::vector<std::pair<double, double>>& angles) {
  const PlainLayout at = plain_layout(model, bytes.size());
  const auto u16 = [&](int i) {
    return bytes[static_cast<size_t>(i)] | bytes[static_cast<size_t>(i + 1)] << 8;
  };
  const int channels = lasers_of(model);
  const int block_size = at.azimuth + 2 + at.unit * channels;
  const int tail = at.header + block_size * blocks_of(model);
  const int returns =
      returns_of(static_cast<ReturnMode>(bytes[static_cast<size_t>(tail + at.mode)]));
  const double rpm = u16(tail + at.speed);
  const int64_t packet_ns =
      plain_seconds(bytes.data() + tail + at.date) * 1'000'000'000 +
      (u16(tail + at.microseconds) + int64_t{65'536} * u16(tail + at.microseconds + 2)) * 1'000;
  const int flag = model == Model::kQt128 ? bytes[static_cast<size_t>(tail + at.mode - 7)] : 1;
  const int count = blocks_of(model) / returns;
  std::vector<PlainFiring> firings(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) {
    PlainFiring& firing = firings[static_cast<size_t>(i)];
    const int loop = model == Model::kQt128 ? (flag + 1 + i) % 2 : 0;
    const int64_t block_ns =
        packet_ns + std::llround(std::floor(manual_block_us(model, i, count) * 1000 + 1e-6));
    std::optional<double> first_us;
    for (int channel = 0; channel < channels; ++channel) {
      const auto us = manual_channel_us(model, channel, loop);
      if (us) first_us = std::min(first_us.value_or(*us), *us);
    }
    firing.first_ns = block_ns + std::llround(*first_us * 1000);
    for (int channel = 0; channel < channels; ++channel) {
      for (int echo = 0; echo < returns; ++echo) {
        const int block = at.header + block_size * (i * returns + echo);
        const int unit = block + at.azimuth + 2 + at.unit * channel;
        PlainReturn r;
        r.block = i * returns + echo;
        r.channel = channel;
        r.distance = u16(unit);
        if (r.distance == 0) continue;
        r.reflectivity = bytes[static_cast<size_t>(unit + 2)];
        r.block_azimuth = u16(block + at.azimuth);
        const double us = manual_channel_us(model, channel, loop).value_or(*first_us);
        const auto& [elevation, offset] = angles[static_cast<size_t>(channel)];
        r.azimuth = r.block_azimuth * 0.01 + offset + rpm * 6e-6 * (us - manual_azimuth_us(model));
        r.elevation = elevation;
        r.time_ns = block_ns + std::llround(us * 1000);
        r.returns = returns;
        r.echo = echo;
        firing.returns.push_back(r);
      }
    }
  }
  return firings;
}

/// The built-in angles of a model, °.
inline std::vector<std::pair<double, double>> built_in_angles(Model model) {
  std::vector<std::pair<double, double>> angles;
  for (int channel = 0; channel < lasers_of(model); ++channel) {
    const BeamAngles& beam = built_in_calibration(model).beams[static_cast<size_t>(channel)];
    constexpr double kRadian = 180 / std::numbers::pi;
    angles.emplace_back(beam.elevation * kRadian, beam.azimuth_offset * kRadian);
  }
  return angles;
}

/// Number of beams whose elevation is below a channel's, of equal ones those before it.
inline int plain_ring(const std::vector<std::pair<double, double>>& angles, int channel) {
  int ring = 0;
  const double own = angles[static_cast<size_t>(channel)].first;
  for (int other = 0; other < static_cast<int>(angles.size()); ++other) {
    const double elevation = angles[static_cast<size_t>(other)].first;
    if (elevation < own || (elevation == own && other < channel)) ++ring;
  }
  return ring;
}

/// Difference of two angles, °, −180 … 180.
inline double apart(double a, double b) { return std::remainder(a - b, 360); }

/// Kinds by the manuals' tables of return modes, in the order of blocks.
inline ReturnKind plain_kind(Model model, ReturnMode mode, int echo) {
  using enum ReturnKind;
  const bool xt = lasers_of(model) <= 32;
  const std::map<int, std::vector<ReturnKind>> kinds{
      {0x33, {kFirst}},
      {0x34, {kSecond}},
      {0x37, {kStrongest}},
      {0x38, {kLast}},
      {0x39, {kLast, kStrongest}},
      {0x3A, {kFirst, kSecond}},
      {0x3B, xt ? std::vector{kLast, kFirst} : std::vector{kFirst, kLast}},
      {0x3C, {kFirst, kStrongest}},
      {0x3D, {kFirst, kLast, kStrongest}},
      {0x3E, {kStrongest, kSecondStrongest}}};
  return kinds.at(static_cast<int>(mode))[static_cast<size_t>(echo)];
}

/// Of the returns of one pulse that are equal, the first, which the decoder gives as kind `kBoth`.
struct MergedReturn {
  PlainReturn of;
  bool both = false;
};

inline std::vector<MergedReturn> merge_equal(const std::vector<PlainReturn>& returns) {
  std::vector<MergedReturn> merged;
  for (const PlainReturn& r : returns) {
    bool equal = false;
    for (MergedReturn& earlier : merged) {
      if (earlier.of.channel == r.channel && earlier.of.distance == r.distance &&
          earlier.of.reflectivity == r.reflectivity) {
        earlier.both = equal = true;
      }
    }
    if (!equal) merged.push_back({r, false});
  }
  return merged;
}

/// Expects the sweeps' returns to be those of the firings, in order of firing: each by ring, range,
/// reflectivity and time exactly, elevation to 1e-4°, azimuth to 1e-3°. Returns their number.
inline size_t expect_equal(Model model, ReturnMode mode, const std::vector<Sweep>& sweeps,
                           const std::vector<PlainFiring>& firings,
                           const std::vector<std::pair<double, double>>& angles) {
  constexpr double kDegree = std::numbers::pi / 180;
  size_t firing = 0;
  size_t compared = 0;
  for (const Sweep& sweep : sweeps) {
    if (firing >= firings.size()) {
      ADD_FAILURE() << "more sweeps than firings";
      return compared;
    }
    const int64_t start_ns = firings[firing].first_ns;
    std::map<std::pair<int, int>, std::vector<size_t>> by_beam;  // column, ring
    for (size_t i = 0; i < sweep.size(); ++i)
      by_beam[{sweep.column[i], sweep.ring[i]}].push_back(i);
    size_t found = 0;
    for (uint32_t column = 0; column < sweep.columns && firing < firings.size(); ++column) {
      const PlainFiring& plain = firings[firing++];
      std::map<int, size_t> taken;  // by ring
      for (const MergedReturn& merged : merge_equal(plain.returns)) {
        const PlainReturn& r = merged.of;
        const int ring = plain_ring(angles, r.channel);
        const auto& candidates = by_beam[{static_cast<int>(column), ring}];
        const size_t at = taken[ring]++;
        if (at >= candidates.size()) {
          ADD_FAILURE() << "no return of channel " << r.channel << " in column " << column;
          return compared;
        }
        const size_t i = candidates[at];
        ++found;
        EXPECT_EQ(sweep.range[i], static_cast<float>(r.distance) * 0.004F);
        EXPECT_EQ(std::lround(sweep.reflectivity[i] * 255), r.reflectivity);
        // A QT64 fires every 500/3 us: each rounds to nanoseconds.
        EXPECT_LE(std::abs(sweep.time_offset_ns[i] - (r.time_ns - start_ns)),
                  model == Model::kQt64 ? 2 : 0);
        EXPECT_EQ(sweep.return_kind[i],
                  merged.both ? ReturnKind::kBoth : plain_kind(model, mode, r.echo));
        const double x = sweep.x[i];
        const double y = sweep.y[i];
        const double z = sweep.z[i];
        EXPECT_NEAR(std::atan2(z, std::hypot(x, y)) / kDegree, r.elevation, 1e-4);
        EXPECT_NEAR(apart(std::atan2(-y, x) / kDegree, r.azimuth), 0, 1e-3);
        EXPECT_NEAR(std::hypot(x, y, z), r.distance * 0.004, 1e-4);
        if (testing::Test::HasFailure()) return compared;
        ++compared;
      }
    }
    EXPECT_EQ(found, sweep.size());
  }
  EXPECT_EQ(firing, firings.size());
  return compared;
}

}  // namespace infuse::hesai
