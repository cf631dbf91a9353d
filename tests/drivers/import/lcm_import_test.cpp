#include "drivers/import/lcm_import.hpp"

#include <gtest/gtest.h>

#include <random>

#include "drivers/import/lcm_packets.hpp"
#include "drivers/recording/capture_reader.hpp"
#include "drivers/recording/drive.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/drivers/lcm/lcm_bytes.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {
namespace {

struct SentBytes {
  int64_t us;
  std::string bytes;
  bool operator==(const SentBytes&) const = default;
};

/// Datagrams of a capture with times in whole µs.
std::vector<SentBytes> read_capture(const std::filesystem::path& path) {
  auto reader = recording::CaptureReader::open(path);
  EXPECT_TRUE(reader) << reader.error().message();
  std::vector<SentBytes> all;
  Datagram datagram;
  while (reader && reader->next(datagram)) {
    const auto& payload = datagram.payload;
    all.push_back({datagram.stamp.ns() / 1000, std::string(payload.begin(), payload.end())});
  }
  return all;
}

/// How a driver puts a packet into a message.
enum class Wrapping { kNone, kRawBytes, kArray };

std::string wrap(const SentBytes& packet, Wrapping wrapping) {
  switch (wrapping) {
    case Wrapping::kNone:
      return packet.bytes;
    case Wrapping::kRawBytes:
      return lcm::make_raw_message(static_cast<uint64_t>(packet.us), packet.bytes);
    case Wrapping::kArray:
      break;
  }
  return "\x77\x77\x77\x77\x77\x77\x77\x77" + lcm::big_endian(static_cast<uint64_t>(packet.us)) +
         packet.bytes + "after";
}

/// A log of packets as they come, each logged 3 ms after its own time, and of poses.
std::string make_log(const std::vector<SentBytes>& packets, Wrapping wrapping,
                     const std::string& channel = "VELODYNE") {
  std::string log;
  uint64_t number = 0;
  for (const SentBytes& packet : packets) {
    const auto logged = static_cast<uint64_t>(packet.us + 3000);
    log += lcm::make_event(number++, logged, channel, wrap(packet, wrapping));
    if (number % 10 == 0) log += lcm::make_event(number++, logged, "POSE", std::string(100, 'p'));
  }
  return log;
}

std::vector<SentBytes> simulated_packets(const ScratchFolder& folder, double seconds = 0.2) {
  const Duration duration(static_cast<int64_t>(seconds * 1e9));
  EXPECT_TRUE(fixtures::make_capture(folder / "in.pcap", {.duration = duration}));
  return read_capture(folder / "in.pcap");
}

void expect_same_packets(const std::vector<SentBytes>& sent, const ScratchFolder& folder,
                         Wrapping wrapping) {
  folder.write("a.lcm", make_log(sent, wrapping));
  std::filesystem::remove_all(folder / "drive");
  const auto imported = import_lcm({folder / "a.lcm"}, folder / "drive");
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->packets, sent.size());
  auto taken = read_capture(folder / "drive/velodyne.pcap");
  if (wrapping == Wrapping::kNone) {  // nothing but the time of logging
    for (SentBytes& packet : taken) packet.us -= 3000;
  }
  EXPECT_EQ(taken, sent);
}

TEST(LcmImport, PacketsAreThoseThatWereSentHoweverTheyAreWrapped) {
  const ScratchFolder folder;
  auto sent = simulated_packets(folder);
  expect_same_packets(sent, folder, Wrapping::kNone);
  expect_same_packets(sent, folder, Wrapping::kRawBytes);
  // A position packet without its length is not taken from a message.
  std::erase_if(sent, [](const SentBytes& packet) { return packet.bytes.size() != 1206; });
  expect_same_packets(sent, folder, Wrapping::kArray);
}

TEST(LcmImport, RealPacketsAreTheSameAfterwards) {
  for (const char* name : {"velodyne/hdl32e-moving.pcap", "velodyne/vlp32c-half-turn.pcap"}) {
    INFUSE_REAL_DATA_OR_SKIP(path, name);
    const ScratchFolder folder;
    expect_same_packets(read_capture(path), folder, Wrapping::kRawBytes);
  }
}

TEST(LcmImport, ChannelsAndTimesAreStated) {
  const ScratchFolder folder;
  const auto sent = simulated_packets(folder);
  folder.write("a.lcm", make_log(sent, Wrapping::kRawBytes, "HDL-32E front"));
  const auto imported = import_lcm({folder / "a.lcm"}, folder / "drive");
  ASSERT_TRUE(imported) << imported.error().message();
  ASSERT_EQ(imported->channels.size(), 2u);
  const LcmChannel& lidar = imported->channels[0];
  EXPECT_EQ(lidar.use, "lidar hdl-32e_front");
  EXPECT_TRUE(lidar.has_own_times);
  EXPECT_NEAR(lidar.lag.median, 0.003, 1e-9);
  EXPECT_NEAR(lidar.rate_hz(), static_cast<double>(sent.size()) / 0.2, 0.01 * lidar.rate_hz());
  EXPECT_EQ(imported->channels[1].name, "POSE");
  EXPECT_EQ(imported->channels[1].use, "");
  EXPECT_EQ(imported->channels[1].smallest, 100u);
  const auto drive = recording::Drive::open(folder / "drive");
  ASSERT_TRUE(drive) << drive.error().message();
  EXPECT_EQ(drive->description.rig.lidars.at(0).model, "HDL-32E");
  EXPECT_EQ(drive->description.gnss_lidar, "hdl-32e_front");
  ASSERT_EQ(imported->notes.size(), 1u);  // of the mounting
}

TEST(LcmImport, SeveralLidarsBecomeSeveralCaptures) {
  const ScratchFolder folder;
  auto sent = simulated_packets(folder);
  std::string log = make_log(sent, Wrapping::kRawBytes, "top!");
  std::erase_if(sent, [](const SentBytes& packet) { return packet.bytes.size() != 1206; });
  folder.write("a.lcm", log + make_log(sent, Wrapping::kNone, "top?"));
  const auto imported = import_lcm({folder / "a.lcm"}, folder / "drive");
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->channels[1].use, "lidar top_");
  EXPECT_EQ(imported->channels[2].use, "lidar top__2");
  EXPECT_EQ(read_capture(folder / "drive/top__2.pcap").size(), sent.size());
}

TEST(LcmImport, PositionPacketsOfAChannelOfTheirOwnAreThoseOfTheOnlyLidar) {
  const ScratchFolder folder;
  const auto sent = simulated_packets(folder);
  std::string log;
  for (size_t k = 0; k < sent.size(); ++k) {
    log += lcm::make_event(k, static_cast<uint64_t>(sent[k].us),
                           sent[k].bytes.size() == 512 ? "GPS" : "LIDAR", sent[k].bytes);
  }
  folder.write("a.lcm", log);
  const auto imported = import_lcm({folder / "a.lcm"}, folder / "drive");
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->channels[0].use, "positions of the lidar lidar");
  EXPECT_EQ(read_capture(folder / "drive/lidar.pcap"), sent);
}

TEST(LcmImport, DamageCostsOnlyTheEventsThere) {
  const ScratchFolder folder;
  const auto sent = simulated_packets(folder);
  std::string log = make_log(sent, Wrapping::kRawBytes);
  // Within the header of a packet's event in the middle, and of the last event of all.
  const size_t in_the_middle = log.find("VELODYNE", log.size() / 2) - 28;
  log.replace(in_the_middle, 10, 10, '\x7F');
  const size_t last = log.rfind("VELODYNE");
  folder.write("a.lcm", log.substr(0, last));
  const auto imported = import_lcm({folder / "a.lcm"}, folder / "drive");
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->packets, sent.size() - 2);
  ASSERT_EQ(imported->notes.size(), 2u);
  EXPECT_NE(imported->notes[0].what.find("2 damaged places, with 1 events"), std::string::npos)
      << imported->notes[0].message();
}

TEST(LcmImport, LogWithoutPacketsIsRefusedAndItsChannelsNamed) {
  const ScratchFolder folder;
  folder.write("a.lcm", lcm::make_event(0, 1, "POSE", "ab") + lcm::make_event(1, 2, "POSE", "c") +
                            lcm::make_event(2, 3, "GPS", std::string(1206, 'x')));
  const auto refused = import_lcm({folder / "a.lcm"}, folder / "drive");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find(
                "channels: GPS (1 messages of 1206 bytes), POSE (2 messages of 1 to 2 bytes)"),
            std::string::npos)
      << refused.error().message();
  EXPECT_FALSE(std::filesystem::exists(folder / "drive"));
  EXPECT_FALSE(import_lcm({folder / "none.lcm"}, folder / "drive"));
  folder.write("other.lcm", "no log at all");
  EXPECT_FALSE(import_lcm({folder / "other.lcm"}, folder / "drive"));
}

TEST(LcmImport, RealLogOfAnotherKindIsRefused) {
  INFUSE_REAL_DATA_OR_SKIP(path, "formats/lcm/example.lcmlog");
  const ScratchFolder folder;
  const auto refused = import_lcm({path}, folder / "drive");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("JOINT_TEST (10 messages of 366 bytes)"),
            std::string::npos)
      << refused.error().message();
}

TEST(LcmImport, MutatedLogsNeitherCrashNorHang) {
  const ScratchFolder folder;
  auto sent = simulated_packets(folder, 0.02);
  const std::string sound = make_log(sent, Wrapping::kRawBytes);
  std::mt19937 random(7);
  size_t imported = 0;
  for (int k = 0; k < 150; ++k) {
    std::string bytes = sound;
    for (size_t n = 1 + random() % 3; n > 0; --n)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    const size_t event = (random() % sent.size()) * (sound.size() / sent.size());
    bytes[event + 4 + random() % 24] = static_cast<char>(random());  // of its header
    folder.write("a.lcm", bytes);
    std::filesystem::remove_all(folder / "drive");
    if (const auto result = import_lcm({folder / "a.lcm"}, folder / "drive")) {
      ++imported;
      EXPECT_GE(result->packets + 8, sent.size());
    }
  }
  EXPECT_EQ(imported, 150u);
}

TEST(LcmPackets, BytesThatOnlyBeginLikeAPacketAreNone) {
  const ScratchFolder folder;
  const std::string packet = simulated_packets(folder, 0.02).front().bytes;
  const auto found = [&](const std::string& message) {
    std::vector<EmbeddedPacket> packets;
    find_packets({reinterpret_cast<const uint8_t*>(message.data()), message.size()}, packets);
    return packets.size();
  };
  EXPECT_EQ(found(packet), 1u);
  EXPECT_EQ(found("abc" + packet + packet + "de" + packet), 3u);
  EXPECT_EQ(found(packet.substr(0, 1205)), 0u);
  EXPECT_EQ(found(packet.substr(1)), 0u);
  EXPECT_EQ(found(std::string(5000, '\xFF')), 0u);
  std::string other = packet;
  other[500] = 0;  // the flag of a block
  EXPECT_EQ(found(other), 0u);
  EXPECT_EQ(found(""), 0u);
}

}  // namespace
}  // namespace infuse::importers
