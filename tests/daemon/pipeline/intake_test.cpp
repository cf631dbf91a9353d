#include "daemon/pipeline/intake.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/stamp_at.hpp"

namespace infuse::daemon {
namespace {

using testing::ElementsAre;
using ItemKind = StreamItem::Kind;

/// An intake of one lidar with decoded sweeps, two cameras of which one is mounted, and an inertial
/// unit.
class IntakeTest : public testing::Test {
 protected:
  IntakeTest() {
    setup_.lidars.push_back({.device = {"top"}, .has_packets = false, .decoder = {}});
    setup_.cameras.resize(2);
    setup_.rig.lidars.push_back({.name = "top"});
    setup_.rig.cameras.push_back({.name = "front", .lidar = "top"});
    setup_.vehicle.imu.emplace();
    intake_.emplace(setup_, ring_);
    intake_->start(at(0));
    intake_->advance(at(0));
  }

  static StreamItem make_item() {
    StreamItem item;
    item.counters.lidars.resize(1);
    item.counters.cameras.resize(2);
    return item;
  }

  void add_imu(double seconds) {
    intake_->advance(at(seconds));
    intake_->add_imu({at(seconds), {}, {}}, at(seconds));
  }

  /// Ends the drive and returns what each item is.
  std::vector<ItemKind> kinds(double end) {
    intake_->end(at(end));
    std::vector<ItemKind> kinds;
    while (Pin<StreamItem> item = reader_.next()) {
      kinds.push_back(item->kind);
      if (item->kind == ItemKind::kSamples) batches_.push_back(item->samples.size());
      if (item->kind == ItemKind::kTick) last_tick_ = std::move(item);
    }
    return kinds;
  }

  SlotRing<StreamItem> ring_{64, make_item};
  SlotRing<StreamItem>::Reader reader_ = ring_.make_reader();
  SensorSetup setup_;
  std::optional<Intake> intake_;
  std::vector<size_t> batches_;
  Pin<StreamItem> last_tick_;
};

TEST_F(IntakeTest, EndsWithAFlushATickAndTheEnd) {
  EXPECT_THAT(kinds(0.5),
              ElementsAre(ItemKind::kStart, ItemKind::kFlush, ItemKind::kTick, ItemKind::kEnd));
}

TEST_F(IntakeTest, TicksEachSecondOfDriveTimeBeforeTheEventThatReachesIt) {
  add_imu(0.5);
  add_imu(2.2);
  EXPECT_THAT(kinds(2.3),
              ElementsAre(ItemKind::kStart, ItemKind::kSamples, ItemKind::kTick, ItemKind::kTick,
                          ItemKind::kSamples, ItemKind::kFlush, ItemKind::kTick, ItemKind::kEnd));
  EXPECT_EQ(last_tick_->counters.imu.received, 2U);
}

TEST_F(IntakeTest, SamplesAreBatchedByNumberAndTime) {
  for (size_t i = 0; i < Intake::kMaxSampleBatch + 1; ++i) add_imu(0.1);
  intake_->push_due_samples(at(0.105));  // too early
  intake_->push_due_samples(at(0.111));
  add_imu(0.112);
  kinds(0.2);
  EXPECT_THAT(batches_, ElementsAre(Intake::kMaxSampleBatch, 1U, 1U));
}

TEST_F(IntakeTest, SamplesPrecedeTheSweepThatFollowsThem) {
  add_imu(0.1);
  Sweep sweep;
  sweep.stamp = at(0.05);
  sweep.resize(3);
  intake_->add_sweep(LidarIndex(0), sweep);
  EXPECT_THAT(kinds(0.2), ElementsAre(ItemKind::kStart, ItemKind::kSamples, ItemKind::kSweep,
                                      ItemKind::kFlush, ItemKind::kTick, ItemKind::kEnd));
  EXPECT_EQ(last_tick_->counters.lidars[0].returns, 3U);
}

TEST_F(IntakeTest, ImagesArePassedOnEncodedAndUnreadableFilesAreCounted) {
  const TemporaryFolder folder;
  std::ofstream(folder / "0.png") << "bytes";
  intake_->add_image_file(CameraIndex(0), at(0.1), 0, folder / "0.png");
  intake_->add_image_file(CameraIndex(0), at(0.2), 2, folder / "absent.png");
  EXPECT_THAT(kinds(0.3), ElementsAre(ItemKind::kStart, ItemKind::kImage, ItemKind::kFlush,
                                      ItemKind::kTick, ItemKind::kEnd));
  EXPECT_EQ(last_tick_->counters.cameras[0].received, 2U);
  EXPECT_EQ(last_tick_->counters.cameras[0].refused, 1U);
  EXPECT_EQ(last_tick_->counters.cameras[0].lost, 1U);  // number 1
}

TEST_F(IntakeTest, ImagesOfACameraWithoutAMountAreOnlyCounted) {
  intake_->add_streamed_image(CameraIndex(1), {.stamp = at(0.1)});
  EXPECT_THAT(kinds(0.3),
              ElementsAre(ItemKind::kStart, ItemKind::kFlush, ItemKind::kTick, ItemKind::kEnd));
  EXPECT_EQ(last_tick_->counters.cameras[1].received, 1U);
}

TEST_F(IntakeTest, DatagramsToNoLidarsPortAreCountedAsUnclaimed) {
  const std::vector<uint8_t> payload(100);
  Datagram datagram;
  datagram.stamp = at(0.1);
  datagram.sender = 0xC0A80102;
  datagram.payload = payload;
  intake_->add_unclaimed_datagram(datagram);
  kinds(0.3);
  EXPECT_EQ(last_tick_->counters.lidars[0].unclaimed, 1U);
  EXPECT_EQ(last_tick_->counters.lidars[0].unexpected_sender, 0xC0A80102);
  EXPECT_EQ(last_tick_->counters.lidars[0].unexpected_size, 100U);
}

}  // namespace
}  // namespace infuse::daemon
