// Damaged input is refused or counted, and never crashes (run with sanitizers).

#include <gtest/gtest.h>

#include <random>

#include "drivers/velodyne/calibration_file.hpp"
#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/position_packet.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/lidar/nmea_sentence.hpp"
#include "fixtures/velodyne/db_xml.hpp"
#include "fixtures/velodyne/position_encoder.hpp"
#include "tests/drivers/velodyne/oracle.hpp"

namespace infuse::velodyne {
namespace {

class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  template <class Bytes>
  void mutate(Bytes& bytes) {
    const size_t count = 1 + random_() % 8;
    for (size_t i = 0; i < count && !bytes.empty(); ++i) {
      const size_t at = random_() % bytes.size();
      switch (random_() % 5) {
        case 0:
          bytes[at] = static_cast<typename Bytes::value_type>(random_());
          break;
        case 1:
          bytes[at] ^= static_cast<typename Bytes::value_type>(1U << random_() % 8);
          break;
        case 2:
          bytes[at] = static_cast<typename Bytes::value_type>(0xFF);
          break;
        case 3:
          bytes[at] = 0;
          break;
        default:
          if (random_() % 8 == 0) bytes.resize(random_() % (bytes.size() + 100));
      }
    }
  }

  // Mutates headers more than returns: azimuths, flags, counter, mode.
  void mutate_headers(std::vector<uint8_t>& packet) {
    if (packet.size() != kPacketSize || random_() % 2 == 0) return;
    const size_t block = random_() % 13;
    const size_t at = block == 12 ? 1200 + random_() % 6 : block * 100 + 2 + random_() % 2;
    packet[at] = static_cast<uint8_t>(random_());
  }

  uint32_t next() { return static_cast<uint32_t>(random_()); }

 private:
  std::mt19937 random_;
};

TEST(MutatedPackets, DataPacketsAreUsedOrCountedWithTheirReason) {
  Mutator mutator(1);
  size_t pushed = 0;
  for (const ModelInfo& info : models()) {
    for (const ReturnMode mode : {ReturnMode::kStrongest, ReturnMode::kDual}) {
      if (mode == ReturnMode::kDual && !info.has_dual_return) continue;
      const Scene scene = make_scene({.model = info.model,
                                      .mode = mode,
                                      .turns = 0.05,
                                      .calibration = built_in_calibration(info.model)});
      Decoder decoder({.model = &lidar_model(info.model)});
      Sweep sweep;
      size_t packets_of_model = 0;
      for (; packets_of_model < 850; ++packets_of_model) {
        SentPacket packet = scene.packets[packets_of_model % scene.packets.size()];
        mutator.mutate(packet.payload);
        mutator.mutate_headers(packet.payload);
        Datagram datagram = packet.datagram();
        if (mutator.next() % 50 == 0) datagram.sender = mutator.next();
        if (mutator.next() % 50 == 0)
          datagram.stamp = Stamp::from_ns(int64_t{mutator.next()} << 31);
        decoder.push(datagram);
        while (decoder.pull(sweep)) {
          ASSERT_EQ(sweep.size(), sweep.return_kind.size());
          ASSERT_LE(sweep.size(), 3'000'000U);
          for (size_t i = 0; i < sweep.size(); ++i) {
            ASSERT_TRUE(std::isfinite(sweep.x[i] + sweep.y[i] + sweep.z[i]));
            ASSERT_LT(sweep.column[i], sweep.columns);
            ASSERT_LT(sweep.ring[i], sweep.rings);
          }
        }
      }
      const lidar::PacketCounters& c = decoder.counters();
      EXPECT_EQ(
          c.packets + c.position_packets + c.malformed + c.wrong_sender + c.duplicates + c.too_late,
          packets_of_model);
      EXPECT_GT(c.malformed, 0U) << info.name;
      EXPECT_GT(c.packets, 0U) << info.name;
      pushed += packets_of_model;
    }
  }
  EXPECT_GE(pushed, 10'000U);
}

TEST(MutatedPackets, PositionPacketsAreReadOrRefused) {
  Mutator mutator(2);
  const std::string sentence = fixtures::rmc_sentence(
      {.utc_ns = 1'700'000'000'000'000'000, .latitude = 0.8, .longitude = -2.1});
  const auto whole = encode_position_packet({.counter_us = 5, .sentence = sentence});
  size_t read = 0;
  size_t with_sentence = 0;
  for (int i = 0; i < 10'000; ++i) {
    std::vector<uint8_t> bytes(whole.begin(), whole.end());
    mutator.mutate(bytes);
    if (bytes.size() == 512)
      bytes[0xCE + mutator.next() % 80] = static_cast<uint8_t>(mutator.next());
    const auto packet = parse_position_packet(bytes);
    if (!packet) continue;
    ++read;
    if (!packet->sentence) continue;
    ++with_sentence;
    ASSERT_TRUE(std::isfinite(packet->sentence->fix.latitude));
  }
  EXPECT_GT(read, 5'000U);
  EXPECT_LT(with_sentence, read / 10);  // the checksum detects nearly all mutations
}

TEST(MutatedPackets, CalibrationFilesAreReadOrRefusedWithAReason) {
  Mutator mutator(3);
  const std::string whole = write_db_xml(built_in_calibration(Model::kHdl64eS2));
  size_t refused = 0;
  for (int i = 0; i < 150; ++i) {
    std::string text = whole;
    mutator.mutate(text);
    const auto calibration = parse_db_xml(text);
    if (calibration) continue;
    ++refused;
    ASSERT_FALSE(calibration.error().what.empty());
  }
  EXPECT_GT(refused, 20U);
}

}  // namespace
}  // namespace infuse::velodyne
