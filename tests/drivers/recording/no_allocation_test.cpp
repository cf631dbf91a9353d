#include <gtest/gtest.h>

#include "drivers/recording/drive_source.hpp"
#include "drivers/recording/pcap_writer.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/drivers/recording/capture_bytes.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

using namespace testing;

// A drive of packets (some fragmented), decoded sweeps, CAN lines and IMU rows: after the first
// tenth, nothing is allocated.
TEST(NoAllocation, ReadingADriveDoesNotAllocatePerEvent) {
  const ScratchFolder folder;
  std::vector<Record> records;
  std::string can, imu = "stamp_ns,wx,wy,wz,ax,ay,az\n", times = "stamp_ns\n";
  for (uint32_t i = 0; i < 1000; ++i) {
    const Bytes datagram = udp(make_payload(1206, i));
    const auto part = static_cast<std::ptrdiff_t>(800);
    const auto id = static_cast<uint16_t>(i);
    const Bytes first_part(datagram.begin(), datagram.begin() + part);
    const Bytes second_part(datagram.begin() + part, datagram.end());
    records.push_back(
        {0, i * 100, ethernet(ipv4(first_part, {.identification = id, .more = true}))});
    records.push_back(
        {0, i * 100, ethernet(ipv4(second_part, {.identification = id, .offset = 800}))});
    can += "(0.0000" + std::to_string(10000 + i) + ") can0 123#0011223344556677\n";
    imu += std::to_string(i * 100) + ",0.1,0.2,0.3,4,5,6.789\n";
  }
  for (int i = 0; i < 20; ++i) {
    times += std::to_string(i * 5000) + "\n";
    const std::string name = (i < 10 ? "00000" : "0000") + std::to_string(i) + ".bin";
    folder.write("sweeps/" + name, std::string(16 * 1000, '\0'));
  }
  const Bytes capture = pcap(kEthernet, records);
  folder.write("lidar.pcap", {capture.begin(), capture.end()});
  folder.write("sweeps/times.csv", times);
  folder.write("can.log", can);
  folder.write("vehicle.dbc", "");
  folder.write("imu.csv", imu);
  DriveDescription description;
  for (const char* name : {"a", "b"}) {
    description.rig.lidars.emplace_back().name = name;
    description.lidars.emplace_back();
  }
  description.lidars[0].packets = "lidar.pcap";
  description.lidars[1].sweeps = "sweeps";
  description.can.emplace();
  description.can->log = "can.log";
  description.can->dbc = "vehicle.dbc";
  description.imu = "imu.csv";
  ASSERT_TRUE(write_drive_toml(folder.path(), description));
  const auto drive = Drive::open(folder.path());
  ASSERT_TRUE(drive);
  auto source = DriveSource::open(*drive);
  ASSERT_TRUE(source);

  DriveEvent event;
  size_t events = 0;
  while (events < 300 && source->next(event)) ++events;
  const size_t before = allocation_count();
  while (source->next(event)) ++events;
  EXPECT_EQ(allocation_count(), before);
  EXPECT_EQ(events, 1000u + 20 + 1000 + 1000);
  if (kAllocationsCounted) {
    EXPECT_GT(before, 0u);
  }
}

TEST(NoAllocation, WritingACaptureDoesNotAllocatePerDatagram) {
  const ScratchFolder folder;
  auto writer = PcapWriter::create(folder / "a.pcap");
  ASSERT_TRUE(writer);
  const Bytes payload = make_payload(1206);
  Datagram datagram;
  datagram.payload = payload;
  ASSERT_TRUE(writer->write(datagram));
  const size_t before = allocation_count();
  bool written = true;
  for (int i = 0; i < 1000; ++i) written = writer->write(datagram).has_value() && written;
  EXPECT_EQ(allocation_count(), before);
  EXPECT_TRUE(written);
}

}  // namespace
}  // namespace infuse::recording
