#include "drivers/recording/pcap_writer.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "drivers/recording/pcap_reader.hpp"
#include "tests/drivers/recording/capture_bytes.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

using namespace testing;

Bytes read_bytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(in), {});
}

Datagram make_datagram(int64_t ns, const Bytes& payload) {
  Datagram datagram;
  datagram.stamp = Stamp::from_ns(ns);
  datagram.sender = kSender;
  datagram.sender_port = 443;
  datagram.destination_port = 2368;
  datagram.payload = payload;
  return datagram;
}

TEST(PcapWriter, WritesHeadersAsTheStandardsRequire) {
  const ScratchFolder folder;
  const Bytes payload = make_payload(3);
  auto writer = PcapWriter::create(folder / "a.pcap");
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->write(make_datagram(0x1'0000'0001, payload), 0xC0A80164));
  EXPECT_EQ(writer->bytes(), 24u + 16 + 14 + 20 + 8 + 3);
  ASSERT_TRUE(writer->close());
  const Bytes file = read_bytes(folder / "a.pcap");
  ASSERT_EQ(file.size(), 24u + 16 + 14 + 20 + 8 + 3);

  const Bytes magic(file.begin(), file.begin() + 4);
  EXPECT_EQ(magic, (Bytes{0x4D, 0x3C, 0xB2, 0xA1}));  // nanoseconds, little-endian
  const Bytes stamp(file.begin() + 24, file.begin() + 32);
  Bytes expected_stamp;
  add_le32(expected_stamp, 4);
  add_le32(expected_stamp, 294'967'297);
  EXPECT_EQ(stamp, expected_stamp);

  // RFC 1071: the sum over a header with a correct checksum is 0xFFFF.
  uint32_t sum = 0;
  for (size_t i = 54; i < 74; i += 2) sum += static_cast<uint32_t>(file[i] << 8 | file[i + 1]);
  while (sum >> 16 != 0) sum = (sum & 0xFFFF) + (sum >> 16);
  EXPECT_EQ(sum, 0xFFFFu);

  Bytes udp_bytes(file.begin() + 74, file.end());
  EXPECT_EQ(udp_bytes, udp(payload, 2368, 443));
}

TEST(PcapWriter, WriteAndReadRoundTrip) {
  const ScratchFolder folder;
  auto writer = PcapWriter::create(folder / "a.pcap");
  ASSERT_TRUE(writer);
  const std::vector<size_t> lengths = {0, 1, 512, 1206, 65507};
  for (size_t i = 0; i < lengths.size(); ++i) {
    const Bytes payload = make_payload(lengths[i], static_cast<uint32_t>(i));
    ASSERT_TRUE(
        writer->write(make_datagram(1'795'216'680'123'456'789 + static_cast<int64_t>(i), payload)));
  }
  ASSERT_TRUE(writer->close());
  EXPECT_EQ(std::filesystem::file_size(folder / "a.pcap"), writer->bytes());

  auto reader = PcapReader::open(folder / "a.pcap");
  ASSERT_TRUE(reader);
  Datagram datagram;
  for (size_t i = 0; i < lengths.size(); ++i) {
    ASSERT_TRUE(reader->next(datagram));
    EXPECT_EQ(datagram.stamp.ns(), 1'795'216'680'123'456'789 + static_cast<int64_t>(i));
    EXPECT_EQ(datagram.sender, kSender);
    EXPECT_EQ(datagram.sender_port, 443);
    EXPECT_EQ(Bytes(datagram.payload.begin(), datagram.payload.end()),
              make_payload(lengths[i], static_cast<uint32_t>(i)));
  }
  EXPECT_FALSE(reader->next(datagram));
  EXPECT_FALSE(reader->damage());
}

TEST(PcapWriter, RejectsWhatTheFormatCannotRepresent) {
  const ScratchFolder folder;
  EXPECT_FALSE(PcapWriter::create(folder / "missing" / "a.pcap"));
  auto writer = PcapWriter::create(folder / "a.pcap");
  ASSERT_TRUE(writer);
  EXPECT_FALSE(writer->write(make_datagram(0, Bytes(65508))));
  EXPECT_FALSE(writer->write(make_datagram(-1, Bytes(1))));
  EXPECT_FALSE(writer->write(make_datagram(int64_t{1} << 62, Bytes(1))));
  EXPECT_TRUE(writer->close());
  EXPECT_FALSE(writer->write(make_datagram(0, Bytes(1))));
  EXPECT_TRUE(writer->close());
}

TEST(PcapWriter, ReportsAFullDisk) {
  auto writer = PcapWriter::create("/dev/full");
  if (!writer) GTEST_SKIP() << "no /dev/full";
  const Bytes payload = make_payload(1206);
  bool failed = false;
  for (int i = 0; i < 1000 && !failed; ++i) failed = !writer->write(make_datagram(i, payload));
  EXPECT_TRUE(failed || !writer->close());
}

}  // namespace
}  // namespace infuse::recording
