#include "drivers/velodyne/calibration_stream.hpp"
#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

#include <gtest/gtest.h>

#include "fixtures/velodyne/status_stream.hpp"
#include "tests/drivers/lidar/assemble.hpp"
#include "tests/drivers/velodyne/oracle.hpp"

namespace infuse::velodyne {
namespace {

/// The first calibration among `packets` packets, and the packet that completed it.
std::optional<Calibration> collect(CalibrationStream& stream, StatusStream& sensor, size_t packets,
                                   size_t* completed = nullptr) {
  for (size_t i = 0; i < packets; ++i) {
    const StatusByte status = sensor.next();
    if (auto calibration = stream.add(status.type, status.value)) {
      if (completed != nullptr) *completed = i;
      return calibration;
    }
  }
  return std::nullopt;
}

void expect_equal(const Calibration& a, const Calibration& b) {
  for (size_t laser = 0; laser < 64; ++laser) {
    EXPECT_DOUBLE_EQ(a.beams[laser].elevation, b.beams[laser].elevation) << laser;
    EXPECT_DOUBLE_EQ(a.beams[laser].rotation, b.beams[laser].rotation) << laser;
    EXPECT_DOUBLE_EQ(a.beams[laser].distance, b.beams[laser].distance) << laser;
    EXPECT_DOUBLE_EQ(a.beams[laser].distance_x, b.beams[laser].distance_x) << laser;
    EXPECT_DOUBLE_EQ(a.beams[laser].distance_y, b.beams[laser].distance_y) << laser;
    EXPECT_DOUBLE_EQ(a.beams[laser].vertical_offset, b.beams[laser].vertical_offset) << laser;
    EXPECT_DOUBLE_EQ(a.beams[laser].horizontal_offset, b.beams[laser].horizontal_offset) << laser;
    EXPECT_DOUBLE_EQ(a.beams[laser].focal_distance, b.beams[laser].focal_distance) << laser;
    EXPECT_DOUBLE_EQ(a.beams[laser].focal_slope, b.beams[laser].focal_slope) << laser;
    EXPECT_EQ(a.beams[laser].min_intensity, b.beams[laser].min_intensity) << laser;
    EXPECT_EQ(a.beams[laser].max_intensity, b.beams[laser].max_intensity) << laser;
  }
}

class EachHdl64e : public testing::TestWithParam<Model> {};

TEST_P(EachHdl64e, ReadsTheCalibrationFromAnyFirstPacket) {
  const Calibration& unit = built_in_calibration(GetParam());
  for (const size_t missed : {size_t{0}, size_t{5}, size_t{1234}, size_t{4159}}) {
    StatusStream sensor(GetParam(), unit);
    for (size_t i = 0; i < missed; ++i) sensor.next();
    CalibrationStream stream(GetParam());
    size_t completed = 0;
    const auto calibration = collect(stream, sensor, 2 * 4160 + 20, &completed);
    ASSERT_TRUE(calibration) << missed;
    expect_equal(*calibration, quantise_calibration(unit));
    EXPECT_GE(completed, 4160U);
  }
}

TEST_P(EachHdl64e, IgnoresABrokenCycleAndReadsTheNextOne) {
  StatusStream sensor(GetParam(), built_in_calibration(GetParam()));
  CalibrationStream stream(GetParam());
  for (size_t i = 0; i < 2000; ++i) {
    const auto status = sensor.next();
    EXPECT_FALSE(stream.add(status.type, status.value));
  }
  while (sensor.next().type != '3') {
  }  // some packets are lost without notice
  size_t completed = 0;
  ASSERT_TRUE(collect(stream, sensor, 3 * 4160, &completed));
  EXPECT_GT(completed, 4160U);
}

INSTANTIATE_TEST_SUITE_P(CalibrationStream, EachHdl64e,
                         testing::Values(Model::kHdl64eS2, Model::kHdl64eS3));

TEST(CalibrationStream, ChecksTheChecksumOfAnS3) {
  StatusStream sensor(Model::kHdl64eS3, built_in_calibration(Model::kHdl64eS3));
  CalibrationStream stream(Model::kHdl64eS3);
  for (size_t i = 0; i < 2 * 4160; ++i) {
    auto status = sensor.next();
    if (i % 4160 == 1003) {  // a byte of the cycle
      ASSERT_EQ(status.type, '3');
      status.value ^= 1;
    }
    ASSERT_FALSE(stream.add(status.type, status.value)) << i;
  }
}

// The published check value of CRC-16 with polynomial 0x8005, not reflected, start 0: 0xFEE8 for
// "123456789". The fixture's checksum is the reference for the decoder, so it is tested itself.
TEST(CalibrationStream, ChecksumMatchesThePublishedCheckValue) {
  uint16_t crc = 0;
  for (const char c : std::string("123456789")) {
    crc = crc16_8005(crc, static_cast<uint8_t>(c));
  }
  EXPECT_EQ(crc, 0xFEE8);
}

TEST(CalibrationStream, IgnoresWarningsBesideTheCycle) {
  StatusStream sensor(Model::kHdl64eS2, built_in_calibration(Model::kHdl64eS2));
  CalibrationStream stream(Model::kHdl64eS2);
  std::optional<Calibration> found;
  for (size_t i = 0; i < 2 * 4160 && !found; ++i) {
    const auto status = sensor.next();
    if (status.type == 'V') stream.add('W', 3);
    found = stream.add(status.type, status.value);
  }
  EXPECT_TRUE(found);
}

// A unit that differs from the example: from its first cycle on, sweeps use its own numbers.
TEST(CalibrationStream, AssemblerUsesTheCalibrationThatTheSensorSends) {
  SceneOptions options;
  options.model = Model::kHdl64eS3;
  options.turns_per_second = 20;
  options.turns = 32;  // 1.6 s
  options.start_azimuth = 0;
  options.calibration = quantise_calibration(built_in_calibration(Model::kHdl64eS2));
  const Scene scene = make_scene(options);
  Decoder decoder({.model = &lidar_model(options.model)});
  EXPECT_EQ(decoder.calibration_source(), lidar::CalibrationSource::kBuiltIn);
  const std::vector<Sweep> sweeps = assemble(decoder, scene.packets);
  EXPECT_EQ(decoder.calibration_source(), lidar::CalibrationSource::kStream);
  ASSERT_EQ(sweeps.size(), scene.sweeps.size());
  const Sweep& sweep = sweeps[30];
  ASSERT_EQ(sweep.size(), scene.sweeps[30].size());
  for (size_t i = 0; i < sweep.size(); ++i) {
    const auto& e = scene.sweeps[30].at({sweep.column[i], sweep.ring[i], sweep.return_kind[i]});
    ASSERT_NEAR(sweep.x[i], e.x, 5e-5);
    ASSERT_NEAR(sweep.y[i], e.y, 5e-5);
    ASSERT_NEAR(sweep.z[i], e.z, 5e-5);
    ASSERT_NEAR(sweep.reflectivity[i], e.reflectivity, 2e-6);
  }
}

}  // namespace
}  // namespace infuse::velodyne
