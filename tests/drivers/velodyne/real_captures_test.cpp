// Real captures compared with the results of other decoders. None of the files is in the
// repository.

#include <gtest/gtest.h>

#include "drivers/measurement/angles.hpp"
#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/model_inference.hpp"
#include "drivers/velodyne/position_packet.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "tests/drivers/lidar/assemble.hpp"
#include "tests/drivers/velodyne/expected_frames.hpp"
#include "tests/pcap_packets.hpp"
#include "tests/real_data.hpp"

namespace infuse::velodyne {
namespace {

TEST(RealMonterey, MatchesTheFramesAndPointsOfTheVendorsViewer) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/hdl32e-monterey.pcap");
  const ExpectedFrames expected = read_expected(real_data("velodyne/hdl32e-monterey.expected.txt"));
  lidar::DecoderOptions options;
  options.model = &lidar_model(Model::kHdl32e);
  options.interpolate_azimuth = false;  // as in the viewer, like the single origin of all beams
  options.single_origin = true;
  Decoder decoder(options);
  const std::vector<Sweep> sweeps = assemble(decoder, data_packets(path));

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

TEST(RealMonterey, EveryPacketIsUsedAndSweepsAreComplete) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/hdl32e-monterey.pcap");
  Decoder decoder({.model = &lidar_model(Model::kHdl32e)});
  const std::vector<Sweep> sweeps = assemble(decoder, data_packets(path));
  const lidar::PacketCounters& counters = decoder.counters();
  EXPECT_EQ(counters.packets, 2702U);
  EXPECT_EQ(counters.lost_network + counters.malformed + counters.duplicates +
                counters.out_of_order + counters.too_late + counters.clock_jumps +
                counters.stray_azimuths,
            0U);
  ASSERT_EQ(sweeps.size(), 19U);
  for (size_t i = 1; i + 1 < sweeps.size(); ++i) {
    EXPECT_TRUE(sweeps[i].gaps.empty()) << i;
    EXPECT_NEAR(to_seconds(sweeps[i].span), 0.0846, 0.001) << i;  // 11.8 turns per second
    EXPECT_NEAR(to_seconds(sweeps[i].stamp - sweeps[i - 1].stamp), to_seconds(sweeps[i - 1].span),
                1e-3)
        << i;
  }
  EXPECT_EQ(sweeps.front().gaps.size(), 1U);  // the capture begins within a turn
}

TEST(RealCaptures, AModelIsInferredFromItsPackets) {
  const std::vector<std::pair<const char*, Model>> captures{
      {"velodyne/hdl32e-monterey.pcap", Model::kHdl32e},
      {"velodyne/hdl32e-moving.pcap", Model::kHdl32e},
      {"velodyne/vlp16-gps.pcap", Model::kVlp16},
      {"velodyne/vlp16-dual-return.pcap", Model::kVlp16},
      {"velodyne/vlp32c-half-turn.pcap", Model::kVlp32c}};
  for (const auto& [name, model] : captures) {
    INFUSE_REAL_DATA_OR_SKIP(path, name);
    ModelInference inference;
    for (const CapturedDatagram& packet : data_packets(path)) inference.add(packet.payload);
    const auto inferred = inference.infer();
    ASSERT_TRUE(inferred.has_value()) << name;
    EXPECT_EQ(model_of(*inferred->model), model) << name << ": " << inferred->reason;
  }
}

TEST(RealCaptures, ClocksThatCountFromPowerUpAreReported) {
  const std::vector<std::tuple<const char*, Model, ClockState::Source>> captures{
      {"velodyne/vlp16-gps.pcap", Model::kVlp16, ClockState::Source::kTopOfHour},
      {"velodyne/vlp16-dual-return.pcap", Model::kVlp16, ClockState::Source::kPowerUp},
      {"velodyne/vlp32c-half-turn.pcap", Model::kVlp32c, ClockState::Source::kPowerUp}};
  for (const auto& [name, model, source] : captures) {
    INFUSE_REAL_DATA_OR_SKIP(path, name);
    Decoder decoder({.model = &lidar_model(model)});
    const auto packets = data_packets(path);
    const std::vector<Sweep> sweeps = assemble(decoder, packets);
    EXPECT_EQ(decoder.clock().source, source) << name;
    // Whatever the counter is, stamps are the host's: within the capture, in order.
    for (const Sweep& sweep : sweeps) {
      EXPECT_GT(sweep.stamp, packets.front().stamp - Duration(50'000'000)) << name;
      EXPECT_LT(sweep.stamp + sweep.span, packets.back().stamp + Duration(1'000'000)) << name;
    }
  }
}

TEST(RealCaptures, PositionPacketsContainTimePositionAndState) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/hdl32e-monterey.pcap");
  size_t count = 0;
  for (const CapturedDatagram& datagram : read_capture(path)) {
    if (datagram.port != 8308) continue;
    ++count;
    const auto packet = parse_position_packet(datagram.payload);
    ASSERT_TRUE(packet.has_value());
    EXPECT_EQ(packet->pps, PpsState::kAbsent);  // although locked: firmware of 2012
    ASSERT_TRUE(packet->sentence.has_value());
    EXPECT_TRUE(packet->sentence->fix.valid);
    EXPECT_NEAR(packet->sentence->fix.latitude / kDegree, 37 + 7.8324 / 60, 1e-4);
    EXPECT_NEAR(packet->sentence->fix.longitude / kDegree, -121 - 39.2864 / 60, 1e-4);
    // The sensor stands upright: the first two units measure gravity along their x.
    EXPECT_NEAR(packet->imu[0].linear_acceleration[0], 9.8, 1.0);
    EXPECT_NEAR(packet->imu[1].linear_acceleration[0], 9.8, 1.0);
    EXPECT_NEAR(packet->imu[0].temperature, 35, 3);
    // The sentence is at most two seconds older than the counter.
    const double age_s = packet->counter_us * 1e-6 -
                         std::fmod(static_cast<double>(packet->sentence->fix.utc_ns) * 1e-9, 3600);
    EXPECT_GT(age_s, 0);
    EXPECT_LT(age_s, 2.1);
  }
  EXPECT_EQ(count, 299U);
}

}  // namespace
}  // namespace infuse::velodyne
