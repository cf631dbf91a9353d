// Real captures compared with the results of other decoders. None of the files is in the
// repository.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <string>

#include "drivers/measurement/angles.hpp"
#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/model_inference.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "tests/drivers/lidar/assemble.hpp"
#include "tests/drivers/velodyne/expected_frames.hpp"
#include "tests/pcap_packets.hpp"
#include "tests/real_data.hpp"

namespace infuse::velodyne {
namespace {

// A PCD file of one kind of record.
template <class Record>
std::vector<Record> read_pcd(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  size_t points = 0;
  while (std::getline(in, line) && line != "DATA binary") {
    if (line.starts_with("POINTS ")) points = std::stoul(line.substr(7));
  }
  std::vector<Record> records(points);
  in.read(reinterpret_cast<char*>(records.data()),
          static_cast<std::streamsize>(points * sizeof(Record)));
  EXPECT_TRUE(in.good());
  return records;
}

struct DualPoint {
  float x, y, z;
  uint8_t intensity, return_type;
  uint16_t channel;
  float azimuth, elevation, distance;
  uint32_t time_ns;
};
static_assert(sizeof(DualPoint) == 32);

double distance(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return (a - b).norm(); }

Eigen::Vector3d position(const Sweep& sweep, size_t i) {
  return {sweep.x[i], sweep.y[i], sweep.z[i]};
}

// The reference has two simplifications. It does not interpolate azimuth in the last pair of blocks
// of a packet, which has no next block (its own time stamps show which these are): there our
// block's azimuth is compared. And it treats the second block of a pair, if that holds another echo
// (return types 5 and 10), as a later firing, in time and in azimuth, which runs ahead by up to
// 0.41°: there only ring and range can agree, and azimuth within that. It cuts at packets, so the
// sweeps differ by some points at their ends.
TEST(RealVlp16DualReturn, ContainsEveryPointOfTheReference) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/vlp16-dual-return.pcap");
  const auto reference = read_pcd<DualPoint>(real_data("velodyne/vlp16-dual-return.reference.pcd"));
  ASSERT_EQ(reference.size(), 14'831U);
  Decoder exact({.model = &lidar_model(Model::kVlp16)});
  Decoder plain({.model = &lidar_model(Model::kVlp16), .interpolate_azimuth = false});
  const auto packets = data_packets(path);
  const std::vector<Sweep> sweeps = assemble(exact, packets);
  const std::vector<Sweep> plain_sweeps = assemble(plain, packets);
  ASSERT_EQ(sweeps.size(), 5U);
  const Sweep& sweep = sweeps[3];  // the turn of the reference
  const Sweep& plain_sweep = plain_sweeps[3];
  ASSERT_EQ(sweep.size(), plain_sweep.size());
  EXPECT_NEAR(static_cast<double>(sweep.size()), 14'831, 60);  // the reference cuts at packets

  constexpr uint32_t kLastPairNs = 20 * 55'296;
  size_t absent = 0;
  size_t near = 0;
  size_t second_echoes = 0;
  for (const DualPoint& point : reference) {
    double best = 1e9;
    for (size_t i = 0; i < sweep.size(); ++i) {
      if (sweep.ring[i] != point.channel || std::abs(sweep.range[i] - point.distance) > 1e-3) {
        continue;
      }
      const Eigen::Vector3d theirs(point.x, point.y, point.z);
      best = std::min(best, distance(position(sweep, i), theirs));
      if (point.time_ns >= kLastPairNs) {
        best = std::min(best, distance(position(plain_sweep, i), theirs));
      }
    }
    if (best > 1e8) ++absent;
    const bool second_echo = point.return_type == 5 || point.return_type == 10;
    const double ahead = second_echo ? 0.41 * kDegree * point.distance : 0;
    if (best < 0.02 + ahead) ++near;
    if (second_echo) ++second_echoes;
  }
  EXPECT_EQ(absent, 0U);
  EXPECT_EQ(second_echoes, 188U);
  EXPECT_GE(static_cast<double>(near), 0.999 * 14'831);
}

TEST(RealVlp16DualReturn, EveryReturnIsStrongestOrLastOrBoth) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/vlp16-dual-return.pcap");
  Decoder decoder({.model = &lidar_model(Model::kVlp16)});
  const auto packets = data_packets(path);
  std::map<ReturnKind, size_t> kinds;
  for (const Sweep& sweep : assemble(decoder, packets)) {
    for (const ReturnKind kind : sweep.return_kind) ++kinds[kind];
  }
  // Counted on the bytes: pairs of equal entries, and entries that are not 0 in other pairs.
  std::map<ReturnKind, size_t> expected;
  for (const CapturedDatagram& packet : packets) {
    for (size_t pair = 0; pair < 6; ++pair) {
      for (size_t slot = 0; slot < 32; ++slot) {
        const uint8_t* last = packet.payload.data() + pair * 200 + 4 + 3 * slot;
        const uint8_t* strongest = last + 100;
        const bool has_last = last[0] != 0 || last[1] != 0;
        const bool has_strongest = strongest[0] != 0 || strongest[1] != 0;
        if (has_last && std::equal(last, last + 3, strongest)) {
          ++expected[ReturnKind::kBoth];
        } else {
          if (has_last) ++expected[ReturnKind::kLast];
          if (has_strongest) ++expected[ReturnKind::kStrongest];
        }
      }
    }
  }
  EXPECT_EQ(kinds, expected);
  EXPECT_GT(expected[ReturnKind::kLast], 500U);
}

struct PlainPoint {
  float x, y, z;
};

// The reference uses the times of a VLP-16 for each laser of a VLP-32C, 2.304 µs · j instead of
// 2.304 µs · ⌊j/2⌋, and again does not interpolate in the last block of a packet. With both applied
// to our block azimuths its points equal ours. It ends with the whole packet that contains the jump
// to the next half turn, so its last points are our next sweep's first.
TEST(RealVlp32cHalfTurn, ContainsEveryPointOfTheReference) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/vlp32c-half-turn.pcap");
  const auto reference = read_pcd<PlainPoint>(real_data("velodyne/vlp32c-half-turn.reference.pcd"));
  ASSERT_EQ(reference.size(), 26'216U);
  // Cut where the sensor does not scan: only its own jump ends a sweep.
  Decoder plain(
      {.model = &lidar_model(Model::kVlp32c), .cut_azimuth = 180, .interpolate_azimuth = false});
  const std::vector<Sweep> sweeps = assemble(plain, data_packets(path));
  ASSERT_EQ(sweeps.size(), 6U);

  const ModelInfo& info = model_info(Model::kVlp32c);
  const auto rings = built_in_calibration(Model::kVlp32c).rings(info);
  std::array<double, 32> laser_of{};
  for (size_t laser = 0; laser < 32; ++laser) laser_of[rings[laser]] = static_cast<double>(laser);
  constexpr double kStep = 19.93 * std::numbers::pi / 18'000;  // 10 turns per second
  std::multimap<long, std::array<Eigen::Vector3d, 2>> ours;    // by distance in its 4 mm units
  const auto insert = [&](const Sweep& sweep, size_t columns) {
    for (size_t i = 0; i < sweep.size() && sweep.column[i] < columns; ++i) {
      const double turned = -kStep * laser_of[sweep.ring[i]] * 2.304 / 55.296;
      const Eigen::Vector3d at = position(sweep, i);
      ours.insert({std::lround(sweep.range[i] / 0.004),
                   {at, Eigen::AngleAxisd(turned, Eigen::Vector3d::UnitZ()) * at}});
    }
  };
  insert(sweeps[0], 100'000);
  insert(sweeps[1], 12);

  size_t absent = 0;
  size_t near = 0;
  for (const PlainPoint& point : reference) {
    const Eigen::Vector3d theirs(point.x, point.y, point.z);
    const auto [begin, end] = ours.equal_range(std::lround(theirs.norm() / 0.004));
    if (begin == end) ++absent;
    double best = 1e9;
    for (auto at = begin; at != end; ++at) {
      best = std::min(best,
                      std::min(distance(at->second[0], theirs), distance(at->second[1], theirs)));
    }
    if (best < 0.02) ++near;
  }
  EXPECT_EQ(absent, 0U);
  EXPECT_GE(static_cast<double>(near), 0.999 * 26'216);
}

TEST(RealVlp32cHalfTurn, SweepsAreHalfTurnsAndReportTheGap) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/vlp32c-half-turn.pcap");
  Decoder decoder({.model = &lidar_model(Model::kVlp32c), .cut_azimuth = 180});
  const std::vector<Sweep> sweeps = assemble(decoder, data_packets(path));
  EXPECT_EQ(decoder.counters().packets, 379U);
  EXPECT_EQ(decoder.counters().lost_network, 0U);  // the 50 ms without packets are not a loss
  ASSERT_EQ(sweeps.size(), 6U);
  for (size_t i = 1; i < 5; ++i) {
    const Sweep& sweep = sweeps[i];
    EXPECT_NEAR(to_seconds(sweep.span), 0.0502, 2e-4);
    EXPECT_NEAR(to_seconds(sweep.stamp - sweeps[i - 1].stamp), 0.1, 1e-3);
    ASSERT_EQ(sweep.gaps.size(), 1U);
    EXPECT_NEAR(sweep.gaps[0].from, -std::numbers::pi / 2, 0.03);
    EXPECT_NEAR(sweep.gaps[0].to, std::numbers::pi / 2, 0.03);
  }
}

TEST(RealVlp32cHalfTurn, PacketsLostAcrossThePauseAreCounted) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/vlp32c-half-turn.pcap");
  const auto whole = data_packets(path);
  // Packets 151, 227, 302 contain the step over the part that is not scanned.
  for (const auto& [first, last] :
       std::vector<std::pair<size_t, size_t>>{{207, 247},
                                              {190, 230},
                                              {226, 266},
                                              {140, 240},
                                              // right behind the packet with the step
                                              {152, 153},
                                              {152, 162},
                                              {152, 182},
                                              {152, 228},
                                              {76, 86}}) {
    auto packets = whole;
    packets.erase(packets.begin() + static_cast<long>(first),
                  packets.begin() + static_cast<long>(last));
    Decoder decoder({.model = &lidar_model(Model::kVlp32c), .cut_azimuth = 180});
    const auto sweeps = assemble(decoder, packets);
    EXPECT_NEAR(static_cast<double>(decoder.counters().lost_network),
                static_cast<double>(last - first), 1)
        << first << " to " << last;
    for (size_t i = 1; i + 1 < sweeps.size(); ++i) {
      EXPECT_LT(to_seconds(sweeps[i].span), 0.0505) << first << " to " << last << ", sweep " << i;
    }
  }
}

}  // namespace
}  // namespace infuse::velodyne
