// Ouster behind the interfaces that all makers share.

#include "drivers/ouster/ouster_maker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <memory>

#include "drivers/ouster/decoder.hpp"
#include "tests/drivers/ouster/made_metadata.hpp"
#include "tests/drivers/ouster/made_packet.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::ouster {
namespace {

using testing::HasSubstr;

constexpr int64_t kHostBegin = 1'700'000'000'000'000'000;

const lidar::LidarModel& os1_64() {
  const lidar::LidarMaker* const list[] = {&maker()};
  return *lidar::find_model(list, "os1 64");
}

void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path) << text;
}

std::vector<uint8_t> inertial_packet(int64_t gyro_ns) {
  std::vector<uint8_t> bytes;
  for (const int64_t time : {gyro_ns, gyro_ns + 1000, gyro_ns}) put<int64_t>(bytes, time);
  for (const float value : {0.0F, 0.0F, 1.0F, 90.0F, 0.0F, 0.0F}) put(bytes, value);
  return bytes;
}

TEST(OusterMaker, TellsItsPacketsFromOthers) {
  const Metadata metadata = parse_metadata(made_metadata({}), "").value();
  EXPECT_EQ(maker().classify(made_packet(metadata, {})), lidar::PacketClass::kData);
  EXPECT_EQ(maker().classify(inertial_packet(5'000'000'000)), lidar::PacketClass::kInertial);
  EXPECT_EQ(maker().classify(std::vector<uint8_t>(48)), lidar::PacketClass::kOther);
  EXPECT_EQ(maker().classify(std::vector<uint8_t>(48, 0xAB)), lidar::PacketClass::kOther);
  EXPECT_EQ(maker().classify(std::vector<uint8_t>(1206)), lidar::PacketClass::kOther);
  EXPECT_EQ(maker().classify({}), lidar::PacketClass::kOther);
}

TEST(OusterMaker, FindsTheMetadataOfThePacketsBesideACapture) {
  const ScratchFolder scratch;
  const auto folder = scratch.path();
  MadeMetadata dual;
  dual.profile = "RNG19_RFL8_SIG16_NIR16_DUAL";
  dual.product_line = "OS-0-64-U1";
  const auto inference = maker().make_inference();
  inference->add(made_packet(parse_metadata(made_metadata(dual), "").value(), {}));
  const auto capture = folder / "run.pcap.gz";
  const auto find = [&] { return maker().find_calibration(capture, {}, *inference); };

  auto found = find();
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message(), HasSubstr("the sensor's metadata is missing"));
  EXPECT_THAT(found.error().message(), HasSubstr("beside NAME.pcap"));

  write_file(folder / "run.json", made_metadata({}));     // of another profile
  write_file(folder / "run2.json", made_metadata(dual));  // beside run2.pcap
  found = find();
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message(), HasSubstr("run.json is of another sensor"));

  write_file(folder / "run.2.json", made_metadata(dual));
  found = find();
  ASSERT_TRUE(found) << found.error().message();
  ASSERT_TRUE(*found);
  EXPECT_STREQ((*found)->model->name, "OS0-64");
  EXPECT_EQ((*found)->calibration, folder / "run.2.json");
  // What is stated counts, whatever lies beside.
  found = maker().find_calibration(capture, folder / "run.json", *inference);
  ASSERT_TRUE(found);
  EXPECT_STREQ((*found)->model->name, "OS1-64");
}

TEST(OusterMaker, RefusesTheMetadataOfAnotherModelAndNone) {
  const ScratchFolder scratch;
  const auto file = scratch.path() / "os.json";
  MadeMetadata values;
  values.product_line = "OS-2-64";
  write_file(file, made_metadata(values));
  const auto loaded = maker().load_calibration(os1_64(), file);
  ASSERT_FALSE(loaded);
  EXPECT_THAT(loaded.error().message(), HasSubstr("a sensor OS2-64, not OS1-64"));
  const auto decoder = lidar::make_decoder({.model = &os1_64()});
  ASSERT_FALSE(decoder);
  EXPECT_THAT(decoder.error().message(), HasSubstr("metadata is missing"));
}

TEST(OusterMaker, DecodesBothKindsOfPackets) {
  const Metadata metadata =
      parse_metadata(made_metadata({.extra_config = R"(, "timestamp_mode": "TIME_FROM_PTP_1588")"}),
                     "")
          .value();
  const auto decoder =
      lidar::make_decoder({.model = &os1_64(),
                           .calibration = std::make_shared<UnitCalibration>(metadata),
                           .cut_azimuth = 180})
          .value();
  // The master's time may be TAI, which is seconds from the host's.
  const int64_t device_begin = kHostBegin - 1'000'000'000;
  Sweep sweep;
  size_t sweeps = 0, samples = 0;
  for (int i = 0; i < 100 * 64; ++i) {
    const int64_t ns = i * int64_t{1'562'500};
    const auto packet =
        made_packet(metadata, {.frame_id = static_cast<uint32_t>(i / 64),
                               .first_measurement_id = static_cast<uint16_t>(i % 64 * 16),
                               .device_ns = device_begin + ns});
    const Stamp stamp = Stamp::from_ns(kHostBegin + ns + 1'562'500);
    decoder->push({stamp, 1, 7502, 7502, packet});
    while (decoder->pull(sweep)) ++sweeps;
    if (i % 10 != 9) continue;
    const auto inertial = inertial_packet(device_begin + ns);
    decoder->push({stamp, 1, 7503, 7503, inertial});
    ImuSample sample;
    ASSERT_TRUE(decoder->pull(sample));
    EXPECT_NEAR(static_cast<double>(sample.stamp.ns() - kHostBegin - ns), 0, 1e6);
    EXPECT_NEAR(sample.angular_velocity[0], 1.5708, 1e-4);
    EXPECT_FALSE(decoder->pull(sample));
    ++samples;
  }
  EXPECT_EQ(sweeps, 99u);
  EXPECT_EQ(samples, 640u);
  EXPECT_EQ(decoder->counters().packets, 6400u);
  EXPECT_EQ(decoder->counters().malformed, 0u);
  EXPECT_EQ(decoder->clock().source, ClockState::Source::kPtp);
  EXPECT_TRUE(decoder->clock().trusted);
  EXPECT_NEAR(decoder->counters().turns_hz, 10, 0.01);
  EXPECT_FALSE(decoder->counters().two_sensors);
}

TEST(OusterMaker, CountsWhatIsNotOfTheLayoutThatTheMetadataStates) {
  const Metadata metadata = parse_metadata(made_metadata({}), "").value();
  MadeMetadata other;
  other.profile = "LEGACY";
  const auto packet = made_packet(parse_metadata(made_metadata(other), "").value(), {});
  const auto decoder =
      lidar::make_decoder(
          {.model = &os1_64(), .calibration = std::make_shared<UnitCalibration>(metadata)})
          .value();
  decoder->push({Stamp::from_ns(kHostBegin), 1, 7502, 7502, packet});
  EXPECT_EQ(decoder->counters().malformed, 1u);
  EXPECT_THAT(decoder->counters().malformed_reason, HasSubstr("metadata"));
}

}  // namespace
}  // namespace infuse::ouster
