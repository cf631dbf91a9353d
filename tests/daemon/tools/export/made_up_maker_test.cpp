// A maker that is only in the list: its capture replays, inspects and exports.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/owner/inspection.hpp"
#include "daemon/tools/export/mcap_export.hpp"
#include "drivers/makers/makers.hpp"
#include "drivers/recording/pcap_writer.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/drivers/makers/made_up_packet.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

constexpr Stamp kFirstPacket = Stamp::from_ns(1'700'000'000'000'000'000);
constexpr uint32_t kPackets = 5 * 125;  // five turns from azimuth 0, cut at 180 degrees
constexpr uint64_t kSweeps = 6;         // the first and the last are half turns

/// Writes a capture of the made-up sensor, with datagrams of nobody among its own.
void write_capture(const std::filesystem::path& path) {
  auto writer = recording::PcapWriter::create(path);
  ASSERT_TRUE(writer);
  const std::vector<uint8_t> noise(33);
  for (uint32_t i = 0; i < kPackets; ++i) {
    const Stamp sent = kFirstPacket + (i + 1) * made_up::kSequences * made_up::kPeriod;
    const auto payload = made_up::packet(i, kFirstPacket, 10);
    ASSERT_TRUE(writer->write({sent, 0x0A000001, 7777, 7777, payload}));
    if (i % 10 == 0) {
      ASSERT_TRUE(writer->write({sent, 0x0A000002, 99, 99, noise}));
    }
  }
  ASSERT_TRUE(writer->close());
}

TEST(MadeUpMaker, ReplaysInspectsAndExports) {
  makers::add(made_up::maker());
  const ScratchFolder folder;
  write_capture(folder / "a.pcap");

  const auto replayed = run_replay(folder / "a.pcap");
  ASSERT_TRUE(replayed) << replayed.error().message();
  ASSERT_EQ(replayed->sensors.size(), 1U);
  EXPECT_EQ(replayed->sensors[0].device.model, "Ringer 4");
  EXPECT_THAT(replayed->sensors[0].device.model_reason,
              testing::HasSubstr("10.0 turns per second"));
  EXPECT_EQ(replayed->totals.counters.lidars[0].packets, kPackets);
  EXPECT_EQ(replayed->totals.counters.lidars[0].sweeps, kSweeps);
  EXPECT_EQ(replayed->totals.counters.lidars[0].returns, uint64_t{kPackets} * 32);
  EXPECT_THAT(replayed->reports, testing::HasSubstr(R"("source":"utc")"));

  ProgressLine line;
  const auto inspected = inspect_recording(folder / "a.pcap", {}, line);
  ASSERT_TRUE(inspected) << inspected.error().message();
  EXPECT_TRUE(has_lidar(*inspected));
  EXPECT_THAT(to_text(*inspected), testing::HasSubstr("Ringer 4"));
  EXPECT_EQ(inspected->contents.survey.streams().size(), 2U);

  const auto exported = export_mcap(folder / "a.pcap", folder / "a.mcap", {});
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_EQ(exported->messages.at("/lidar/lidar/points_raw"), kSweeps);
}

}  // namespace
}  // namespace infuse::daemon
