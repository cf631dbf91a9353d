// Real captures against what other decoders make of them. None of the files is in the repository.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <string>

#include "tests/drivers/velodyne/assemble.hpp"
#include "tests/pcap_packets.hpp"
#include "tests/real_data.hpp"

namespace infuse::velodyne {
namespace {

constexpr uint16_t kDataPort = 2368;

std::vector<CapturedDatagram> data_packets(const std::filesystem::path& path) {
  std::vector<CapturedDatagram> packets = read_capture(path);
  std::erase_if(packets, [](const CapturedDatagram& d) { return d.port != kDataPort; });
  return packets;
}

struct ExpectedPoint {
  size_t frame, index;
  double x, y, z, reflectivity;  // vendor axes: x right, y forward
};

struct ExpectedFrames {
  size_t frames = 0;
  std::map<size_t, size_t> counts;
  std::vector<ExpectedPoint> points;
};

ExpectedFrames read_expected(const std::filesystem::path& path) {
  ExpectedFrames expected;
  std::ifstream in(path);
  std::string word;
  size_t frame = 0;
  while (in >> word) {
    if (word == "frame_count") in >> expected.frames;
    if (word == "frame") in >> frame;
    if (word == "point_count") in >> expected.counts[frame];
    if (word == "point_values") {
      ExpectedPoint p{frame, 0, 0, 0, 0, 0};
      double flag = 0;
      in >> p.index >> p.x >> p.y >> p.z >> p.reflectivity >> flag;
      expected.points.push_back(p);
    }
  }
  return expected;
}

TEST(RealMonterey, FramesAndPointsAreThoseOfTheVendorsViewer) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/hdl32e-monterey.pcap");
  const ExpectedFrames expected = read_expected(real_data("velodyne/hdl32e-monterey.expected.txt"));
  SweepAssemblerOptions options;
  options.model = Model::kHdl32e;
  options.interpolate_azimuth = false;  // as the viewer did
  SweepAssembler assembler(options);
  const std::vector<Sweep> sweeps = assemble(assembler, data_packets(path));

  ASSERT_EQ(expected.frames, 19U);
  ASSERT_EQ(sweeps.size(), expected.frames);
  ASSERT_EQ(expected.counts.size(), 5U);
  for (const auto& [frame, count] : expected.counts)
    EXPECT_EQ(sweeps[frame].size(), count) << frame;
  size_t all = 0;
  for (const Sweep& sweep : sweeps) all += sweep.size();
  EXPECT_EQ(all, 872'800U);

  ASSERT_EQ(expected.points.size(), 4U);
  for (const ExpectedPoint& point : expected.points) {
    const Sweep& sweep = sweeps[point.frame];
    EXPECT_NEAR(-sweep.y[point.index], point.x, 1e-3) << point.index;
    EXPECT_NEAR(sweep.x[point.index], point.y, 1e-3) << point.index;
    EXPECT_NEAR(sweep.z[point.index], point.z, 1e-3) << point.index;
    EXPECT_NEAR(sweep.reflectivity[point.index] * 255, point.reflectivity, 1e-3) << point.index;
  }
}

TEST(RealMonterey, EveryPacketIsUsedAndSweepsAreWhole) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/hdl32e-monterey.pcap");
  SweepAssembler assembler({.model = Model::kHdl32e});
  const std::vector<Sweep> sweeps = assemble(assembler, data_packets(path));
  const PacketCounters& counters = assembler.counters();
  EXPECT_EQ(counters.packets, 2702U);
  EXPECT_EQ(counters.network_lost + counters.all_malformed() + counters.duplicates +
                counters.out_of_order + counters.too_late + counters.clock_jumps +
                counters.wrong_model,
            0U);
  ASSERT_EQ(sweeps.size(), 19U);
  for (size_t i = 1; i + 1 < sweeps.size(); ++i) {
    EXPECT_TRUE(sweeps[i].gaps.empty()) << i;
    EXPECT_NEAR(to_seconds(sweeps[i].span), 0.0846, 0.001) << i;  // 11.8 turns a second
    EXPECT_NEAR(to_seconds(sweeps[i].stamp - sweeps[i - 1].stamp), to_seconds(sweeps[i - 1].span),
                1e-3)
        << i;
  }
  EXPECT_EQ(sweeps.front().gaps.size(), 1U);  // the capture begins within a turn
}

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

}  // namespace
}  // namespace infuse::velodyne
