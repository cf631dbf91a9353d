// Captures of real sensors against digests that Ouster's own tools made of them, and against
// another decoder in double precision, point by point, which reads packets and metadata by itself.
// Skipped without INFUSE_REAL_DATA.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/uuid/detail/md5.hpp>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "drivers/ouster/imu_packet.hpp"
#include "drivers/ouster/turn_assembler.hpp"
#include "drivers/recording/pcap_reader.hpp"

namespace infuse::ouster {
namespace {

using Json = nlohmann::json;
using recording::PcapReader;

std::string md5(const void* data, size_t size) {
  boost::uuids::detail::md5 hash;
  hash.process_bytes(data, size);
  boost::uuids::detail::md5::digest_type digest;
  hash.get_digest(digest);
  std::string text;
  for (const unsigned int word : digest) {
    for (int shift = 28; shift >= 0; shift -= 4) text += "0123456789abcdef"[word >> shift & 15];
  }
  return text;
}

/// Concatenated arrays of a field, whose digest is asked for.
class FieldBytes {
 public:
  template <class T>
  void add(T value) {
    const size_t at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  std::string digest() const { return md5(bytes_.data(), bytes_.size()); }

 private:
  std::vector<uint8_t> bytes_;
};

class OusterCapture : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const char* data = std::getenv("INFUSE_REAL_DATA");
    if (data == nullptr) GTEST_SKIP() << "INFUSE_REAL_DATA is not set";
    const std::filesystem::path folder = std::filesystem::path(data) / "lidars" / "ouster";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
    base_ = (folder / GetParam()).string();
    digest_ = Json::parse(std::ifstream(base_ + "_digest.json"));
    json_ = Json::parse(std::ifstream(base_ + ".json"));
    metadata_ = load_metadata(base_ + ".json").value();
  }

  /// All payloads of the lidar or of the inertial unit, with their stamps.
  std::vector<std::pair<Stamp, std::vector<uint8_t>>> payloads(bool inertial) const {
    std::vector<std::pair<Stamp, std::vector<uint8_t>>> result;
    auto reader = PcapReader::open(base_ + ".pcap").value();
    for (Datagram datagram; reader.next(datagram);) {
      if ((datagram.payload.size() == kImuPacketSize) == inertial) {
        result.emplace_back(datagram.stamp,
                            std::vector<uint8_t>(datagram.payload.begin(), datagram.payload.end()));
      }
    }
    return result;
  }

  /// The sweeps of the capture.
  std::vector<Sweep> sweeps() const {
    ClockModelOptions clock;
    clock.modulo = Duration(0);
    lidar::PacketCounters counters;
    lidar::Losses losses(counters);
    TurnAssembler assembler(*metadata_, {.cut_azimuth = 180}, clock, counters, losses);
    std::vector<Sweep> result;
    Sweep sweep;
    const auto pull = [&] {
      while (assembler.pull(sweep)) result.push_back(std::exchange(sweep, {}));
    };
    for (const auto& [stamp, payload] : payloads(false)) {
      assembler.push({stamp, 1, 7502, 7502, payload}, {});
      pull();
    }
    assembler.finish();
    pull();
    EXPECT_EQ(counters.lost_network, 0u);
    EXPECT_EQ(counters.packets, 64u);
    return result;
  }

  std::string expected(const char* field) const {
    return digest_["packet_hash"].value(field, std::string());
  }

  std::string base_;
  Json digest_, json_;
  std::optional<Metadata> metadata_;
};

TEST_P(OusterCapture, HasTheFieldsOfTheDigests) {
  const PacketLayout layout(*metadata_);
  const ProfileInfo& profile = *layout.profile;
  std::map<std::string, FieldBytes> fields;
  for (const auto& [stamp, payload] : payloads(false)) {
    const auto packet = parse_packet(layout, payload);
    ASSERT_TRUE(packet) << describe(packet.error());
    for (uint16_t i = 0; i < packet->count; ++i) {
      fields["TIMESTAMP"].add(static_cast<uint64_t>(packet->columns[i].device_ns));
      fields["MEASUREMENT_ID"].add(packet->columns[i].measurement_id);
    }
    for (size_t beam = 0; beam < metadata_->beams(); ++beam) {
      for (uint16_t i = 0; i < packet->count; ++i) {
        const uint8_t* pixel = packet->columns[i].pixels + beam * profile.pixel_bytes;
        const auto add = [&](const EchoFields& echo, const std::string& suffix) {
          fields["RANGE" + suffix].add(echo.range.read(pixel));
          fields["REFLECTIVITY" + suffix].add(static_cast<uint8_t>(echo.reflectivity.read(pixel)));
          fields["SIGNAL" + suffix].add(static_cast<uint16_t>(echo.signal.read(pixel)));
        };
        add(profile.echo[0], "");
        if (profile.echoes == 2) add(profile.echo[1], "2");
        fields["NEAR_IR"].add(static_cast<uint16_t>(profile.near_infrared.read(pixel)));
      }
    }
  }
  ASSERT_GE(fields.size(), 6u);
  for (const auto& [name, bytes] : fields) {
    EXPECT_EQ(bytes.digest(), expected(name.c_str())) << name;
  }
}

TEST_P(OusterCapture, MakesTheSweepOfTheDigests) {
  const std::vector<Sweep> all = sweeps();
  ASSERT_EQ(all.size(), 1u);
  const Sweep& sweep = all[0];
  const size_t beams = metadata_->beams();
  // Beams on the wire go downwards, rings upwards.
  const auto at = [&](size_t i) { return (beams - 1 - sweep.ring[i]) * 1024 + sweep.column[i]; };
  std::array<std::vector<uint32_t>, 2> range;
  std::array<std::vector<uint8_t>, 2> reflectivity;
  for (auto& image : range) image.resize(beams * 1024);
  for (auto& image : reflectivity) image.resize(beams * 1024);
  const bool dual = profile_info(metadata_->profile).echoes == 2;
  for (size_t i = 0; i < sweep.size(); ++i) {
    const ReturnKind kind = sweep.return_kind[i];
    const size_t echo =
        dual && (kind == ReturnKind::kLast || kind == ReturnKind::kSecondStrongest) ? 1 : 0;
    ASSERT_EQ(range[echo][at(i)], 0u);
    range[echo][at(i)] = static_cast<uint32_t>(std::lround(sweep.range[i] * 1000.0));
    reflectivity[echo][at(i)] =
        static_cast<uint8_t>(std::lround(static_cast<double>(sweep.reflectivity[i]) * 255));
  }
  const Json& scan = digest_["scans"][0];
  const auto hash = [](const auto& image) {
    return md5(image.data(), image.size() * sizeof image[0]);
  };
  EXPECT_EQ(hash(range[0]), scan["RANGE"].get<std::string>());
  if (dual) {
    EXPECT_EQ(hash(range[1]), scan["RANGE2"].get<std::string>());
  }
  // A pixel without a return may have a reflectivity; a sweep does not hold it.
  EXPECT_EQ(sweep.columns, 1024u);
  EXPECT_TRUE(sweep.gaps.empty());
}

/// A return by Ouster's published formula, in double precision.
struct BruteReturn {
  double x, y, z, range, reflectivity;
  int64_t device_ns;
};

/// Decodes a capture's payloads by the packet layouts of the manual, without the code under test.
/// By beam · 4096 + measurement id; the second echoes in the second map.
std::array<std::map<size_t, BruteReturn>, 2> brute_force(
    const Json& json, const std::vector<std::pair<Stamp, std::vector<uint8_t>>>& payloads) {
  const std::vector<double> altitude = json["beam_altitude_angles"];
  const std::vector<double> azimuth = json["beam_azimuth_angles"];
  const std::vector<double> to_sensor = json["lidar_to_sensor_transform"];
  const double n = json["lidar_origin_to_beam_origin_mm"];
  const std::string profile = json["data_format"].value("udp_profile_lidar", "LEGACY");
  const bool legacy = profile == "LEGACY", dual = profile.ends_with("_DUAL");
  const size_t pixel_bytes = dual ? 16 : 12;
  const size_t column_bytes = (legacy ? 20 : 12) + altitude.size() * pixel_bytes;
  std::array<std::map<size_t, BruteReturn>, 2> result;
  const auto number = [](const uint8_t* bytes, size_t count) {
    uint64_t value = 0;
    for (size_t i = count; i-- > 0;) value = value << 8 | bytes[i];
    return value;
  };
  for (const auto& [stamp, payload] : payloads) {
    for (size_t i = 0; i < 16; ++i) {
      const uint8_t* column = payload.data() + (legacy ? 0 : 32) + i * column_bytes;
      const size_t id = number(column + 8, 2);
      const double encoder = 2 * std::numbers::pi * (1 - static_cast<double>(id) / 1024);
      for (size_t beam = 0; beam < altitude.size(); ++beam) {
        const uint8_t* pixel = column + (legacy ? 16 : 12) + beam * pixel_bytes;
        for (size_t echo = 0; echo < (dual ? 2u : 1u); ++echo) {
          const auto r =
              static_cast<double>(number(pixel + 4 * echo, 3) & (legacy ? 0xFFFFF : 0x7FFFF));
          if (r == 0) continue;
          const double turned = encoder - azimuth[beam] * std::numbers::pi / 180;
          const double phi = altitude[beam] * std::numbers::pi / 180;
          const std::array<double, 3> lidar{
              (r - n) * std::cos(turned) * std::cos(phi) + n * std::cos(encoder),
              (r - n) * std::sin(turned) * std::cos(phi) + n * std::sin(encoder),
              (r - n) * std::sin(phi)};
          std::array<double, 3> p{};
          for (size_t k = 0; k < 3; ++k) {
            p[k] = (to_sensor[4 * k] * lidar[0] + to_sensor[4 * k + 1] * lidar[1] +
                    to_sensor[4 * k + 2] * lidar[2] + to_sensor[4 * k + 3]) /
                   1000;
          }
          result[echo][beam * 4096 + id] = {
              p[0],
              p[1],
              p[2],
              r / 1000,
              static_cast<double>(pixel[dual ? 3 + 4 * echo : 4]) / 255,
              static_cast<int64_t>(number(column, 8))};
        }
      }
    }
  }
  return result;
}

TEST_P(OusterCapture, HasThePointsOfThePublishedFormula) {
  const auto expected = brute_force(json_, payloads(false));
  const std::vector<Sweep> all = sweeps();
  ASSERT_EQ(all.size(), 1u);
  const Sweep& sweep = all[0];
  ASSERT_EQ(sweep.size(), expected[0].size() + expected[1].size());
  const size_t beams = metadata_->beams();
  const bool dual = profile_info(metadata_->profile).echoes == 2;
  int64_t first_ns = INT64_MAX;
  for (const auto& [place, value] : expected[0]) first_ns = std::min(first_ns, value.device_ns);
  double largest = 0;
  for (size_t i = 0; i < sweep.size(); ++i) {
    const size_t place = (beams - 1 - sweep.ring[i]) * 4096 + sweep.column[i];
    const ReturnKind kind = sweep.return_kind[i];
    const size_t echo =
        dual && (kind == ReturnKind::kLast || kind == ReturnKind::kSecondStrongest) ? 1 : 0;
    const auto found = expected[echo].find(place);
    ASSERT_NE(found, expected[echo].end());
    const BruteReturn& truth = found->second;
    largest = std::max({largest, std::abs(sweep.x[i] - truth.x), std::abs(sweep.y[i] - truth.y),
                        std::abs(sweep.z[i] - truth.z)});
    ASSERT_FLOAT_EQ(sweep.range[i], static_cast<float>(truth.range));
    ASSERT_FLOAT_EQ(sweep.reflectivity[i], static_cast<float>(truth.reflectivity));
    ASSERT_EQ(sweep.time_offset_ns[i], truth.device_ns - first_ns);
    if (dual) {
      const auto other = expected[1 - echo].find(place);
      const bool last = other == expected[1 - echo].end() || truth.range >= other->second.range;
      ASSERT_EQ(kind == ReturnKind::kLast || kind == ReturnKind::kBoth, last);
    }
  }
  EXPECT_LT(largest, 1e-4);
  RecordProperty("largest_deviation_um", static_cast<int>(largest * 1e6));
}

TEST_P(OusterCapture, HasTheInertialValuesToTheBit) {
  for (const auto& [stamp, payload] : payloads(true)) {
    const auto packet = parse_imu_packet(payload);
    ASSERT_TRUE(packet);
    EXPECT_EQ(std::memcmp(packet->acceleration_g.data(), payload.data() + 24, 12), 0);
    EXPECT_EQ(std::memcmp(packet->rate_deg_per_s.data(), payload.data() + 36, 12), 0);
    EXPECT_EQ(std::memcmp(&packet->gyro_ns, payload.data() + 16, 8), 0);
    EXPECT_EQ(std::memcmp(&packet->accelerometer_ns, payload.data() + 8, 8), 0);
    const ImuSample sample = to_sample(*packet, metadata_->T_sensor_imu, stamp);
    EXPECT_NEAR(std::hypot(sample.linear_acceleration[0], sample.linear_acceleration[1],
                           sample.linear_acceleration[2]),
                9.81, 0.5);  // these sensors stood
  }
}

INSTANTIATE_TEST_SUITE_P(Captures, OusterCapture,
                         testing::Values("OS-0-32-U1_v2.2.0_1024x10", "OS-1-32-G_v2.1.1_1024x10",
                                         "OS-2-128-U1_v2.3.0_1024x10"),
                         [](const auto& test) {
                           std::string name(test.param);
                           std::ranges::replace_if(
                               name, [](char c) { return !std::isalnum(c); }, '_');
                           return name;
                         });

}  // namespace
}  // namespace infuse::ouster
