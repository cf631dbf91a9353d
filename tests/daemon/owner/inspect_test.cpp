// What the programs say about captures that are damaged, misleading or misread.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "drivers/velodyne/packet.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/lidar/little_endian.hpp"
#include "fixtures/scene/capture.hpp"
#include "fixtures/velodyne/db_xml.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/folders.hpp"
#include "tests/raw_capture.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using velodyne::Model;

struct Inspection {
  int code = -1;
  json found;

  std::string problems() const { return found["problems"].dump(); }
  const json& lidar() const { return found["devices"][0]; }
};

class InspectTest : public testing::Test {
 protected:
  RawCapture make(Model model, double seconds, double rotation_hz = 10) {
    fixtures::CaptureOptions options;
    options.model = &velodyne::lidar_model(model);
    options.duration = from_seconds(seconds);
    options.rotation_hz = rotation_hz;
    EXPECT_TRUE(fixtures::make_capture(path_, options));
    return RawCapture::read(path_);
  }

  Inspection inspect(const RawCapture& capture, const std::string& options = "") {
    capture.write(path_);
    return inspect(path_, options);
  }

  static Inspection inspect(const std::filesystem::path& path, const std::string& options = "") {
    const ProgramResult result = run_shell_command(programs_folder() + "/infuse inspect --json " +
                                                   options + " " + path.string() + " 2>/dev/null");
    EXPECT_TRUE(result.output.empty() || is_result(result.output, "inspect"));
    return {result.code, json::parse(result.output, nullptr, false)};
  }

  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "x.pcap";
};

TEST_F(InspectTest, TheModelIsJudgedByPacketsNotByTheProductByte) {
  RawCapture capture = make(Model::kVlp16, 1, 20);
  for (RawCapture::Record* record : capture.data()) record->payload()[1205] = 0x21;
  const Inspection right = inspect(capture);
  EXPECT_EQ(right.problems(), "[]");
  EXPECT_EQ(right.lidar()["model"], "VLP-16");
  EXPECT_EQ(right.lidar()["level"], "OK");
  EXPECT_THAT(right.lidar()["model_reason"], HasSubstr("product byte 0x21 says HDL-32E"));

  const Inspection wrong = inspect(capture, "--model HDL-32E");
  EXPECT_EQ(wrong.lidar()["level"], "ERROR");
  EXPECT_THAT(wrong.problems(), AllOf(HasSubstr("another model's than HDL-32E"),
                                      HasSubstr("a VLP-16's, though product byte 0x21")));
  EXPECT_THAT(wrong.problems(), HasSubstr("its azimuth jumps"));
  EXPECT_NEAR(wrong.lidar()["sweeps_hz"], 20, 0.05);
}

TEST_F(InspectTest, ARateThatNoSensorHasIsAProblem) {
  RawCapture capture = make(Model::kVlp16, 1);
  for (RawCapture::Record* record : capture.data()) {
    for (size_t block = 0; block < 12; ++block) {  // ten turns become 2.5
      uint8_t* azimuth = record->block(block) + 2;
      fixtures::write_u16(azimuth, static_cast<uint16_t>(velodyne::read_u16(azimuth) / 4));
    }
  }
  EXPECT_THAT(inspect(capture).problems(), HasSubstr("it turns 2.5"));
}

TEST_F(InspectTest, PositionPacketsWithVeloViewsIpv4LengthAreRead) {
  RawCapture capture = make(Model::kVlp16, 1);
  RawCapture positions{capture.header, {}};
  for (RawCapture::Record& record : capture.records) {
    if (!record.is_position()) continue;
    record.frame[16] = 1234 >> 8;
    record.frame[17] = 1234 & 255;
    positions.records.push_back(record);
  }
  const Inspection both = inspect(capture);
  EXPECT_EQ(both.lidar()["position_packets"], positions.records.size());
  EXPECT_EQ(both.problems(), "[]");
  const Inspection alone = inspect(positions);
  EXPECT_EQ(alone.code, 1);
  EXPECT_THAT(alone.problems(), HasSubstr("datagrams of 512 bytes"));
}

TEST_F(InspectTest, UndecodablePacketsAreAProblemInAShortCapture) {
  const Inspection all = inspect(make(Model::kVls128, 0.1), "--model HDL-64E-S3");
  EXPECT_EQ(all.code, 1);
  EXPECT_EQ(all.lidar()["level"], "ERROR");
  EXPECT_THAT(all.problems(), HasSubstr("datagrams are not packets of HDL-64E S3"));

  RawCapture capture = make(Model::kVlp16, 0.3);
  fixtures::write_u16(capture.data()[20]->block(3), 0xBBFF);  // lasers 96 ... 127
  capture.data().back()->payload()[1205] = 0x77;
  const Inspection one = inspect(capture);
  EXPECT_EQ(one.code, 0);
  EXPECT_EQ(one.lidar()["model"], "VLP-16");
  EXPECT_EQ(one.lidar()["level"], "WARN");
  EXPECT_EQ(one.lidar()["losses"]["malformed"], 1);
  EXPECT_EQ(one.lidar()["packets_lost"], 0);
  EXPECT_THAT(one.problems(), HasSubstr("1 datagrams are not packets of VLP-16"));
}

TEST_F(InspectTest, AnotherUnitsCalibrationIsAProblem) {
  const RawCapture capture = make(Model::kHdl64eS3, 0.3);  // shorter than its calibration cycle
  const Inspection without = inspect(capture);
  EXPECT_THAT(without.problems(),
              AllOf(HasSubstr("calibration of another unit"), HasSubstr("--calibration")));
  const ProgramResult decoded =
      run_shell_command(programs_folder() + "/infuse decode " + path_.string() + " --sweep 1 -o " +
                        (folder_ / "x.pcd").string() + " 2>&1");
  EXPECT_THAT(decoded.output, HasSubstr("calibration of another unit"));

  std::ofstream(folder_ / "db.xml")
      << velodyne::write_db_xml(velodyne::built_in_calibration(Model::kHdl64eS3));
  EXPECT_EQ(inspect(capture, "--calibration " + (folder_ / "db.xml").string()).problems(), "[]");
}

TEST_F(InspectTest, TheCalibrationInThePacketsIsUsedFromTheFirstSweep) {
  const Inspection whole = inspect(make(Model::kHdl64eS3, 1.7));
  EXPECT_EQ(whole.lidar()["uncalibrated_sweeps"], 0);
}

TEST_F(InspectTest, NmeaDecidesIfTheDeviceCountsFromTheHour) {
  RawCapture capture = make(Model::kVlp16, 0.5);
  for (RawCapture::Record& record : capture.records) record.seconds += 1;  // the host's clock
  EXPECT_EQ(inspect(capture).lidar()["clock"]["source"], "top_of_hour");
  std::erase_if(capture.records, [](const auto& record) { return record.is_position(); });
  EXPECT_EQ(inspect(capture).lidar()["clock"]["source"], "power_up");
}

TEST_F(InspectTest, TwoSensorsOfOneAddressAreNamed) {
  const RawCapture one = make(Model::kHdl32e, 0.5);
  RawCapture both{one.header, {}};
  for (RawCapture::Record record : one.records) {
    both.records.push_back(record);
    if (!record.is_data()) continue;
    for (size_t block = 0; block < 12; ++block) {
      uint8_t* azimuth = record.block(block) + 2;
      const int turned = velodyne::read_u16(azimuth) + 9000;
      fixtures::write_u16(azimuth, static_cast<uint16_t>(turned % 36'000));
    }
    const uint64_t counter = velodyne::read_u32(record.payload() + 1200) + uint64_t{1'234'567'891};
    fixtures::write_u32(record.payload() + 1200, static_cast<uint32_t>(counter % 3'600'000'000));
    both.records.push_back(record);
  }
  const Inspection found = inspect(both);
  EXPECT_EQ(found.lidar()["level"], "ERROR");
  EXPECT_THAT(found.problems(), AllOf(HasSubstr("two sensors"), HasSubstr("its clock jumps")));
}

TEST_F(InspectTest, TheSweepRateIsThatOfTheTurns) {
  EXPECT_NEAR(inspect(make(Model::kVlp16, 0.35, 9.99)).lidar()["sweeps_hz"], 9.99, 0.01);
}

TEST_F(InspectTest, StrayAzimuthsAreOneCounter) {
  RawCapture capture = make(Model::kHdl32e, 0.5);
  const Inspection before = inspect(capture);
  fixtures::write_u16(capture.data()[300]->block(3) + 2, 12'345);
  fixtures::write_u16(capture.data()[500]->block(0) + 2, 40'000);
  const Inspection found = inspect(capture);
  EXPECT_EQ(found.lidar()["stray_azimuths"], 2);
  EXPECT_EQ(found.lidar()["losses"]["malformed"], 0);
  EXPECT_EQ(found.lidar()["packets_lost"], 0);
  EXPECT_EQ(found.lidar()["sweeps"], before.lidar()["sweeps"]);
  EXPECT_THAT(found.problems(), HasSubstr("2 azimuths"));
}

TEST_F(InspectTest, MessagesGiveTheRightReasons) {
  const RawCapture capture = make(Model::kVlp16, 0.2);
  RawCapture ipv6 = capture;
  for (RawCapture::Record& record : ipv6.records) {
    record.frame[12] = 0x86;  // an IPv6 packet of the same length, of ICMPv6
    record.frame[13] = 0xDD;
    const size_t length = record.frame.size() - 14 - 40;
    record.frame[14] = 0x60;
    record.frame[18] = static_cast<uint8_t>(length >> 8);
    record.frame[19] = static_cast<uint8_t>(length);
    record.frame[20] = 58;
  }
  const Inspection six = inspect(ipv6);
  EXPECT_EQ(six.code, 1);
  EXPECT_THAT(six.problems(), HasSubstr("packets of IPv6"));

  RawCapture snapped = capture;
  for (RawCapture::Record& record : snapped.records) record.frame.resize(96);
  const Inspection cut = inspect(snapped);
  EXPECT_EQ(cut.code, 1);
  EXPECT_THAT(cut.problems(), HasSubstr("tcpdump -s 0"));

  RawCapture few{capture.header, {capture.records.begin(), capture.records.begin() + 6}};
  const Inspection six_packets = inspect(few);
  EXPECT_EQ(six_packets.code, 1);
  EXPECT_THAT(six_packets.problems(), HasSubstr("6 lidar packets are too few"));
}

/// Datagrams of the right size from elsewhere are no lidar's, and do not spoil the one that is
/// there.
TEST_F(InspectTest, RandomDatagramsBesideAGoodLidarAreNamedAndNothingElse) {
  const RawCapture capture = make(Model::kHdl32e, 0.5);
  RawCapture mixed{capture.header, {}};
  uint32_t noise = 1;
  for (size_t i = 0; i < capture.records.size(); ++i) {
    mixed.records.push_back(capture.records[i]);
    if (i % 10 != 0 || !capture.records[i].is_data()) continue;
    RawCapture::Record other = capture.records[i];
    other.frame[29] = 77;  // the sender
    for (size_t k = RawCapture::kPayload; k < other.frame.size(); ++k) {
      noise = noise * 1'664'525 + 1'013'904'223;
      other.frame[k] = static_cast<uint8_t>(noise >> 24);
    }
    mixed.records.push_back(other);
  }
  const Inspection alone = inspect(capture), found = inspect(mixed);
  EXPECT_EQ(found.code, 0);
  EXPECT_EQ(found.problems(), "[]");
  EXPECT_EQ(found.lidar()["sweeps"], alone.lidar()["sweeps"]);
  EXPECT_THAT(found.found["streams"].dump(), HasSubstr("other datagrams"));
}

TEST_F(InspectTest, PacketsThatCameTwiceAreAProblem) {
  const RawCapture capture = make(Model::kVlp16, 0.3);
  RawCapture twice{capture.header, {}};
  for (const RawCapture::Record& record : capture.records) {
    twice.records.insert(twice.records.end(), 2, record);
  }
  EXPECT_THAT(inspect(twice).problems(), HasSubstr("packets came twice"));
}

/// The sweeps are those of a steady clock, but for the moment of the step.
TEST_F(InspectTest, AClockThatWasSetBackIsNamedAndTheTurnsAreRight) {
  RawCapture capture = make(Model::kHdl32e, 1);
  const Inspection steady = inspect(capture);
  for (size_t i = capture.records.size() / 2; i < capture.records.size(); ++i) {
    capture.records[i].seconds -= 2;
  }
  const Inspection found = inspect(capture);
  EXPECT_THAT(found.problems(),
              AllOf(HasSubstr("was set back 1 time(s), by up to"), Not(HasSubstr("jumps"))));
  EXPECT_EQ(found.lidar()["sweeps"], steady.lidar()["sweeps"]);
}

TEST_F(InspectTest, SentencesAtThePortOfDataAreUsed) {
  RawCapture capture = make(Model::kVlp16, 0.5);
  for (RawCapture::Record& record : capture.records) {
    if (record.is_position())
      std::copy_n(capture.data()[0]->frame.begin() + 36, 2, record.frame.begin() + 36);
  }
  EXPECT_THAT(inspect(capture).found["sensors"].dump(), HasSubstr("gnss"));
}

TEST_F(InspectTest, CutAzimuthsWrap) {
  make(Model::kVlp16, 0.3);
  const auto decode = [&](const char* cut) {
    return run_shell_command(programs_folder() + "/infuse decode --json --cut " + cut + " " +
                             path_.string() + " -o " + (folder_ / "c.bin").string());
  };
  const ProgramResult negative = decode("-90");
  EXPECT_EQ(negative.code, 0);
  EXPECT_TRUE(is_result(negative.output, "decode"));
  EXPECT_EQ(negative.output, decode("270").output);
}

TEST_F(InspectTest, ARealCaptureOfOldFirmwareIsAVlp16) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/vlp16-gps.pcap");
  RawCapture capture = RawCapture::read(path);
  for (RawCapture::Record* record : capture.data()) record->payload()[1205] = 0x21;
  const Inspection found = inspect(capture);
  EXPECT_EQ(found.lidar()["model"], "VLP-16");
  EXPECT_EQ(found.problems(), "[]");
  EXPECT_NEAR(found.lidar()["sweeps_hz"], 10, 0.1);
}

TEST_F(InspectTest, RealCapturesHaveNoProblems) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "velodyne");
  for (const char* name :
       {"hdl32e-monterey", "hdl32e-moving", "vlp16-gps", "vlp16-dual-return", "vlp32c-half-turn"}) {
    const Inspection found = inspect(folder / (std::string(name) + ".pcap"));
    EXPECT_EQ(found.problems(), "[]") << name;
    EXPECT_EQ(found.code, 0);
  }
  // Its counter is 0.92 s off the host's clock, and agrees with its NMEA sentences.
  EXPECT_EQ(inspect(folder / "hdl32e-monterey.pcap").lidar()["clock"]["source"], "top_of_hour");
}

}  // namespace
}  // namespace infuse::daemon
