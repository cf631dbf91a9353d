// Real captures of three models, and the cloud that another driver made of one turn of each: points
// in the vendor's axes (x right, y forward), at the azimuth of their block plus the channel's
// offset, without what the rotor turns until the channel fires.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>

#include "drivers/hesai/calibration_file.hpp"
#include "drivers/hesai/decoder.hpp"
#include "drivers/hesai/hesai_maker.hpp"
#include "tests/drivers/hesai/oracle.hpp"
#include "tests/drivers/lidar/assemble.hpp"
#include "tests/pcap_packets.hpp"
#include "tests/real_data.hpp"

namespace infuse::hesai {
namespace {

struct Capture {
  Model model;
  ReturnMode mode;
  const char* capture;
  const char* angles;
  size_t points;  ///< of the cloud
};

constexpr Capture kCaptures[]{
    {Model::kPandar40p, ReturnMode::kLastStrongest, "40p", "Pandar40P", 56'762},
    {Model::kQt64, ReturnMode::kFirstLast, "qt64", "PandarQT64", 34'158},
    {Model::kXt32, ReturnMode::kLastStrongest, "xt32", "PandarXT32", 63'021}};

class HesaiCapture : public testing::TestWithParam<Capture> {
 protected:
  /// Decodes the capture; false if it is not there.
  bool decode() {
    const auto folder = real_data("lidars/hesai");
    const auto& capture = GetParam();
    if (folder.empty() || !std::filesystem::exists(folder)) return false;
    const auto calibration =
        load_angle_csv(folder / (std::string(capture.angles) + ".csv"), model_info(capture.model));
    EXPECT_TRUE(calibration);
    packets_ = read_capture(folder / (std::string(capture.capture) + ".pcap"));
    decoder_ = std::make_unique<Decoder>(lidar::DecoderOptions{
        .model = &lidar_model(capture.model),
        .calibration = std::make_shared<UnitCalibration>(capture.model, *calibration)});
    sweeps_ = assemble(*decoder_, packets_);
    angles_ = read_angles(folder / (std::string(capture.angles) + ".csv"));
    for (const CapturedDatagram& packet : packets_) {
      for (PlainFiring& firing : plain_decode(capture.model, packet.payload, angles_)) {
        firings_.push_back(std::move(firing));
      }
    }
    return true;
  }

  static std::vector<std::pair<double, double>> read_angles(const std::filesystem::path& path) {
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    std::vector<std::pair<double, double>> angles;
    for (int channel = 0; std::getline(file, line);) {
      double elevation = 0;
      double azimuth = 0;
      if (std::sscanf(line.c_str(), "%d,%lf,%lf", &channel, &elevation, &azimuth) == 3) {
        angles.emplace_back(elevation, azimuth);
      }
    }
    return angles;
  }

  /// The cloud's points: x, y, z as 32-bit floats after the header.
  static std::vector<std::array<float, 3>> read_cloud(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    const std::string bytes = text.str();
    const size_t data = bytes.find("DATA binary\n") + 12;
    std::vector<std::array<float, 3>> points((bytes.size() - data) / 12);
    std::memcpy(points.data(), bytes.data() + data, points.size() * 12);
    return points;
  }

  std::vector<CapturedDatagram> packets_;
  std::unique_ptr<Decoder> decoder_;
  std::vector<Sweep> sweeps_;
  std::vector<std::pair<double, double>> angles_;
  std::vector<PlainFiring> firings_;
};

TEST_P(HesaiCapture, IsDecodedAsAPlainDecoderDoes) {
  if (!decode()) GTEST_SKIP() << "no lidars/hesai under INFUSE_REAL_DATA";
  const auto& [model, mode, name, angles, points] = GetParam();
  EXPECT_GE(sweeps_.size(), 3u);
  EXPECT_GT(expect_equal(model, mode, sweeps_, firings_, angles_), 100'000u);
  const lidar::PacketCounters& counters = decoder_->counters();
  EXPECT_EQ(counters.packets, packets_.size());
  EXPECT_EQ(counters.malformed, 0u);
  EXPECT_EQ(counters.lost_network, 0u);
  EXPECT_EQ(counters.duplicates, 0u);
  EXPECT_EQ(counters.stray_azimuths, 0u);
  EXPECT_NEAR(counters.turns_hz, 10, 0.05);
}

TEST_P(HesaiCapture, HoldsEveryPointOfTheOtherDriversCloud) {
  if (!decode()) GTEST_SKIP() << "no lidars/hesai under INFUSE_REAL_DATA";
  const auto& [model, mode, name, angles, count] = GetParam();
  constexpr double kDegree = std::numbers::pi / 180;
  // Ours, by ring and range: azimuth without the firing time, which the plain decoder knows.
  std::map<std::pair<int, int>, std::vector<double>> ours;
  size_t firing = 0;
  for (const Sweep& sweep : sweeps_) {
    for (size_t i = 0; i < sweep.size(); ++i) {
      const PlainFiring& plain = firings_[firing + sweep.column[i]];
      const int distance = static_cast<int>(std::lround(sweep.range[i] / 0.004F));
      for (const PlainReturn& r : plain.returns) {
        if (r.distance != distance || plain_ring(angles_, r.channel) != sweep.ring[i]) continue;
        const double turned =
            r.azimuth - r.block_azimuth * 0.01 - angles_[static_cast<size_t>(r.channel)].second;
        ours[{sweep.ring[i], distance}].push_back(std::atan2(-sweep.y[i], sweep.x[i]) / kDegree -
                                                  turned);
        break;
      }
    }
    firing += sweep.columns;
  }
  const auto points = read_cloud(real_data("lidars/hesai/" + std::string(name) + ".pcd"));
  ASSERT_EQ(points.size(), count);
  size_t missing = 0;
  for (const auto& [x, y, z] : points) {
    const double range = std::hypot(double{x}, double{y}, double{z});
    const double elevation = std::asin(z / range) / kDegree;
    const double azimuth = std::atan2(x, y) / kDegree;
    bool found = false;
    for (int channel = 0; channel < static_cast<int>(angles_.size()) && !found; ++channel) {
      if (std::abs(angles_[static_cast<size_t>(channel)].first - elevation) > 1e-4) continue;
      const auto at =
          ours.find({plain_ring(angles_, channel), static_cast<int>(std::lround(range / 0.004))});
      if (at == ours.end()) continue;
      for (const double our_azimuth : at->second) {
        found = found || std::abs(apart(our_azimuth, azimuth)) < 0.01;
      }
    }
    missing += found ? 0 : 1;
  }
  EXPECT_EQ(missing, 0u) << "of " << count;
}

INSTANTIATE_TEST_SUITE_P(Models, HesaiCapture, testing::ValuesIn(kCaptures),
                         [](const auto& test) { return std::string(test.param.capture); });

}  // namespace
}  // namespace infuse::hesai
