// A real capture with two clouds that another driver made of it. The capture is named after a
// 16-beam model, and the clouds were made with that model's angles; its packets are those of an
// RS-Helios-5515: they state its type, the information packet holds 32 beams, a packet of one
// return holds 12 blocks in 0.67 ms, and the floor is flat in all beams with these angles only.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/robosense/decoder.hpp"
#include "drivers/robosense/robosense_maker.hpp"
#include "tests/drivers/lidar/assemble.hpp"
#include "tests/drivers/robosense/oracle.hpp"
#include "tests/pcap_packets.hpp"
#include "tests/real_data.hpp"

namespace infuse::robosense {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// One point of a cloud.
struct CloudPoint {
  int intensity, ring;
  double azimuth, elevation;  ///< °
  int distance;               ///< 2.5 mm
};

std::vector<CloudPoint> read_cloud(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line) && line != "DATA ascii") {
  }
  std::vector<CloudPoint> points;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    double x, y, z, intensity, type, channel, azimuth, elevation, distance;
    if (words >> x >> y >> z >> intensity >> type >> channel >> azimuth >> elevation >> distance) {
      points.push_back({static_cast<int>(intensity), static_cast<int>(channel), azimuth * 0.01,
                        elevation * 0.01, static_cast<int>(std::lround(distance / 0.0025))});
    }
  }
  return points;
}

class RobosenseCapture : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = real_data("lidars/robosense");
    if (folder_.empty() || !std::filesystem::exists(folder_)) {
      GTEST_SKIP() << "no lidars/robosense under INFUSE_REAL_DATA";
    }
    packets_ = read_capture(folder_ / "helios16P.pcap");
    ASSERT_EQ(packets_.size(), 751u);
    for (const CapturedDatagram& packet : packets_) {
      if (packet.port == 7788) info_ = packet;
    }
    for (int channel = 0; channel < 32; ++channel) {
      angles_.emplace_back(angle(468 + 3 * channel), angle(564 + 3 * channel));
    }
    firings_ = plain_decode(32, false, data_payloads(packets_));
  }

  double angle(int at) const {
    const double degrees = big_endian_16(info_.payload, at + 1) * 0.01;
    return info_.payload[static_cast<size_t>(at)] == 0 ? degrees : -degrees;
  }

  /// Sweeps of the capture by a decoder that knows the information packet from the start.
  std::vector<Sweep> decode(Model model = Model::kHelios) {
    Decoder first({.model = &lidar_model(model)});
    first.push(packets_[0].datagram());
    Sweep sweep;
    first.pull(sweep);
    first.push(info_.datagram());
    decoder_ = std::make_unique<Decoder>(lidar::DecoderOptions{
        .model = &lidar_model(model), .calibration = first.streamed_calibration()});
    return assemble(*decoder_, packets_);
  }

  std::filesystem::path folder_;
  std::vector<CapturedDatagram> packets_;
  CapturedDatagram info_;
  PlainAngles angles_;
  std::vector<PlainFiring> firings_;
  std::unique_ptr<Decoder> decoder_;
};

TEST_F(RobosenseCapture, IsDecodedAsAPlainDecoderDoes) {
  const auto sweeps = decode();
  EXPECT_EQ(sweeps.size(), 6u);
  EXPECT_GT(expect_equal(sweeps, firings_, angles_), 130'000u);
  const lidar::PacketCounters& counters = decoder_->counters();
  EXPECT_EQ(counters.packets, 750u);
  EXPECT_EQ(counters.position_packets, 1u);
  EXPECT_EQ(counters.malformed, 0u);
  EXPECT_EQ(counters.lost_network, 0u);
  EXPECT_EQ(counters.duplicates, 0u);
  EXPECT_EQ(counters.stray_azimuths, 0u);
  EXPECT_EQ(counters.wrong_model, 0u);
  EXPECT_NEAR(counters.turns_hz, 10, 0.05);
}

/// The clouds are those of an RS-Helios-16P, whose second firing channels 17 … 32 would be: decoded
/// as one, each point is a return of ours.
TEST_F(RobosenseCapture, HoldsEveryPointOfTheOtherDriversClouds) {
  const auto sweeps = decode(Model::kHelios16p);
  // Ours, by their ring, distance and reflectivity: azimuth, from the origin of the beam.
  std::map<std::tuple<int, int, int>, std::vector<double>> ours;
  for (const Sweep& sweep : sweeps) {
    for (size_t i = 0; i < sweep.size(); ++i) {
      const double offset = angles_[static_cast<size_t>(15 - sweep.ring[i])].second;
      // The origin is 34.98 mm before the axis, in the direction of the rotor.
      double azimuth = std::atan2(-sweep.y[i], sweep.x[i]) / kDegree;
      for (int turn = 0; turn < 20; ++turn) {
        const double rotor = (azimuth - offset) * kDegree;
        azimuth = std::atan2(-sweep.y[i] - 0.03498 * std::sin(rotor),
                             sweep.x[i] - 0.03498 * std::cos(rotor)) /
                  kDegree;
      }
      ours[{sweep.ring[i], static_cast<int>(std::lround(sweep.range[i] / 0.0025F)),
            static_cast<int>(std::lround(sweep.reflectivity[i] * 255))}]
          .push_back(azimuth);
    }
  }
  for (const auto& [name, count] :
       {std::pair("1691031766781547066.pcd", 15'258u), {"1691031766880833506.pcd", 15'795u}}) {
    const auto points = read_cloud(folder_ / name);
    ASSERT_EQ(points.size(), count);
    size_t missing = 0;
    size_t close = 0;  // theirs is ours, but offset and step are each cut off to 0.01°
    for (const CloudPoint& point : points) {
      const double elevation = angles_[static_cast<size_t>(15 - point.ring)].first;
      missing += std::abs(point.elevation - elevation) < 0.0101 ? 0 : 1;
      double least = 360;
      for (const double azimuth : ours[{point.ring, point.distance, point.intensity}]) {
        const double difference = std::remainder(azimuth - point.azimuth, 360);
        if (std::abs(difference) < std::abs(least)) least = difference;
      }
      close += std::abs(least) < 0.0205 ? 1 : 0;
      missing += std::abs(least) < 0.06 ? 0 : 1;
    }
    EXPECT_EQ(missing, 0u) << "of " << count;
    // The last block's step is another packet's, and not known to a sensor of half the rate.
    EXPECT_GT(close, count * 999 / 1000);
  }
}

/// The floor below the sensor: beams from −25° to −31° see it at one height.
TEST_F(RobosenseCapture, TheFloorIsFlatWithTheUnitsAngles) {
  const auto sweeps = decode();
  std::map<int, std::map<int, int>> heights;  // by ring: number of returns by cm
  for (const Sweep& sweep : sweeps) {
    for (size_t i = 0; i < sweep.size(); ++i) {
      if (sweep.range[i] > 1) ++heights[sweep.ring[i]][static_cast<int>(sweep.z[i] * 100)];
    }
  }
  for (const int channel : {21, 22, 23, 24, 25}) {
    const auto& of_ring = heights[plain_ring(angles_, channel)];
    const auto most = std::max_element(of_ring.begin(), of_ring.end(),
                                       [](auto& a, auto& b) { return a.second < b.second; });
    EXPECT_NEAR(most->first, -68, 1.5) << "channel " << channel;
  }
}

TEST_F(RobosenseCapture, StatesItsModel) {
  const auto inference = maker().make_inference();
  for (const CapturedDatagram& packet : packets_) inference->add(packet.payload);
  ASSERT_NE(inference->judge(), nullptr);
  EXPECT_STREQ(inference->judge()->name, "RS-Helios");
  EXPECT_NEAR(inference->turns_per_second(), 10, 0.05);
}

}  // namespace
}  // namespace infuse::robosense
