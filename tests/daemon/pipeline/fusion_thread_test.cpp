#include "daemon/pipeline/fusion_thread.hpp"
#include "tests/fusion/streetmap/town.hpp"
#include "tests/stamp_at.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>

namespace infuse::daemon {
namespace {

using testing::ElementsAre;
using Kind = ReportItem::Kind;

constexpr Duration kSpan{90'000'000};

/// A fusion thread of one lidar and one camera, run on the test's thread after its items.
class FusionThreadTest : public testing::Test {
 protected:
  FusionThreadTest() {
    setup_.calibration.monitored = false;
    setup_.rig.lidars.push_back({.name = "top"});
    CameraMount camera;
    camera.name = "front";
    camera.lidar = "top";
    camera.intrinsics.width = camera.intrinsics.height = 32;
    camera.intrinsics.fx = camera.intrinsics.fy = 16;
    camera.intrinsics.cx = camera.intrinsics.cy = 15.5;
    camera.T_camera_lidar.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    setup_.rig.cameras.push_back(camera);
  }

  FusionThread& thread() {
    if (!thread_) thread_.emplace(setup_, items_, images_, reports_, notifier_);
    return *thread_;
  }

  StreamItem& slot(StreamItem::Kind kind, Stamp stamp) {
    thread();  // reads what is published from now on
    StreamItem& item = items_.slot();
    item.kind = kind;
    item.stamp = stamp;
    item.read_at = HostClock::now();
    return item;
  }

  void push(StreamItem::Kind kind, Stamp stamp) {
    slot(kind, stamp);
    items_.publish();
  }

  /// A sweep of one return, 10 m ahead.
  void push_sweep(Stamp stamp, HostClock::time_point read_at = HostClock::now()) {
    StreamItem& item = slot(StreamItem::Kind::kSweep, stamp);
    item.read_at = read_at;
    Sweep& sweep = item.sweep;
    sweep.resize(1);
    sweep.stamp = stamp;
    sweep.span = kSpan;
    sweep.x[0] = sweep.range[0] = 10;
    sweep.y[0] = sweep.z[0] = sweep.reflectivity[0] = 0;
    sweep.time_offset_ns[0] = 0;
    items_.publish();
  }

  /// An image, and its decoded form.
  void push_image(Stamp stamp, bool readable = true, int size = 32) {
    slot(StreamItem::Kind::kImage, stamp).number = image_count_;
    items_.publish();
    CameraImage& image = images_.slot();
    image.stamp = stamp;
    image.number = image_count_++;
    image.readable = readable;
    image.frame.width = image.frame.height = size;
    image.frame.pixels.assign(static_cast<size_t>(size) * static_cast<size_t>(size), 255);
    images_.publish();
  }

  /// Runs to the end and returns the reports.
  std::vector<ReportItem> run(Stamp end) {
    push(StreamItem::Kind::kFlush, end);
    push(StreamItem::Kind::kTick, end);
    push(StreamItem::Kind::kEnd, end);
    thread().run();
    std::vector<ReportItem> reports;
    while (const Pin<ReportItem> report = reader_.next()) reports.push_back(*report);
    return reports;
  }

  static std::vector<Kind> kinds(const std::vector<ReportItem>& reports) {
    std::vector<Kind> kinds;
    for (const ReportItem& report : reports) kinds.push_back(report.kind);
    return kinds;
  }

  static StreamItem make_item() {
    StreamItem item;
    item.counters.lidars.resize(1);
    item.counters.cameras.resize(1);
    return item;
  }
  static ReportItem make_report() {
    ReportItem item;
    item.counters.lidars.resize(1);
    item.counters.cameras.resize(1);
    return item;
  }

  boost::asio::io_context io_;
  Notifier notifier_{io_, [] {}};
  SlotRing<StreamItem> items_{256, make_item};
  SlotRing<CameraImage> images_{64, [] { return CameraImage(); }};
  SlotRing<ReportItem> reports_{256, make_report};
  SlotRing<ReportItem>::Reader reader_ = reports_.make_reader();
  FusionSetup setup_;
  std::optional<FusionThread> thread_;
  uint64_t image_count_ = 0;
};

TEST_F(FusionThreadTest, WithoutOdometryASweepIsReportedAtOnceAndAsMeasured) {
  push(StreamItem::Kind::kStart, at(0));
  push_sweep(at(0));
  push(StreamItem::Kind::kTick, at(0.1));
  const auto reports = run(at(1));
  EXPECT_THAT(kinds(reports),
              ElementsAre(Kind::kStart, Kind::kSweep, Kind::kTick, Kind::kTick, Kind::kEnd));
  EXPECT_EQ(reports[1].sweep.device, "top");
  EXPECT_EQ(reports[1].sweep.returns, 1U);
  EXPECT_STREQ(reports[1].sweep.deskew_reason, "no odometry");
  EXPECT_EQ(reports[2].odometry.not_deskewed, 0U);
}

TEST_F(FusionThreadTest, ASweepWaitsForOdometryAtMostTheConfiguredTime) {
  setup_.has_odometry = setup_.has_motion_sensor = true;
  setup_.odometry.max_wait = from_seconds(0.2);
  push(StreamItem::Kind::kStart, at(0));
  push_sweep(at(0));
  push(StreamItem::Kind::kTick, at(0.2));  // 0.11 s after the sweep's end
  push(StreamItem::Kind::kTick, at(0.3));
  const auto reports = run(at(1));
  EXPECT_THAT(kinds(reports), ElementsAre(Kind::kStart, Kind::kTick, Kind::kSweep, Kind::kPose,
                                          Kind::kTick, Kind::kTick, Kind::kEnd));
  EXPECT_STRNE(reports[2].sweep.deskew_reason, "");
  EXPECT_EQ(reports[3].pose.stamp, at(0) + kSpan);
  EXPECT_FALSE(reports[3].pose.usable());
  EXPECT_EQ(reports[4].odometry.not_deskewed, 1U);
}

TEST_F(FusionThreadTest, AMapTakesThePlaceOfTheOneInUseWhichItsPosterKeeps) {
  setup_.has_odometry = true;
  const auto town = streetmap::town::build(streetmap::town::plan());
  setup_.maps.street_map.map = town.map;
  setup_.streetmap.initial_pose = InitialPose{0, 0, 0};
  push(StreamItem::Kind::kStart, at(0));
  const auto tasks = thread().make_map_tasks({.street_map = {{}, town.map, {}}});
  const StreetMapTracker* next = tasks->street_map.get();
  ASSERT_NE(next, nullptr);
  EXPECT_EQ(tasks->places, nullptr);
  thread().post(tasks);
  push_sweep(at(0));
  const auto reports = run(at(1));
  EXPECT_NE(tasks->street_map.get(), next);
  EXPECT_NE(tasks->street_map, nullptr);
  EXPECT_EQ(tasks.use_count(), 1);
  EXPECT_TRUE(reports.back().kind == Kind::kEnd && reports[reports.size() - 2].streetmap);
}

TEST_F(FusionThreadTest, AFlushProcessesTheSweepsThatWait) {
  setup_.has_odometry = setup_.has_motion_sensor = true;
  push(StreamItem::Kind::kStart, at(0));
  push_sweep(at(0));
  EXPECT_THAT(kinds(run(at(0.1))),
              ElementsAre(Kind::kStart, Kind::kSweep, Kind::kPose, Kind::kTick, Kind::kEnd));
}

TEST_F(FusionThreadTest, ALateSweepIsNotRegisteredAndAVeryLateOneIsDroppedIfLive) {
  setup_.has_odometry = true;
  setup_.odometry.use_lidar = true;
  for (const Delivery delivery : {Delivery::kWait, Delivery::kOverwrite}) {
    thread_.reset();
    setup_.delivery = delivery;
    const Duration ages[] = {Duration::zero(), from_seconds(0.5), from_seconds(5)};
    for (size_t i = 0; i < std::size(ages); ++i) {
      push_sweep(at(0.1 * static_cast<double>(i)), HostClock::now() - ages[i]);
    }
    const auto reports = run(at(1));
    const bool live = delivery == Delivery::kOverwrite;
    const auto sweeps = std::count_if(reports.begin(), reports.end(), [](const ReportItem& report) {
      return report.kind == Kind::kSweep;
    });
    EXPECT_EQ(sweeps, live ? 2 : 3);
    const ReportItem& tick = reports[reports.size() - 2];
    ASSERT_EQ(tick.kind, Kind::kTick);
    EXPECT_EQ(tick.skipped_registrations, live ? 1U : 0U);
    EXPECT_EQ(tick.counters.lidars[0].dropped_sweeps, live ? 1U : 0U);
  }
}

TEST_F(FusionThreadTest, ASweepThatHasWaitedForOdometryIsRegistered) {
  setup_.has_odometry = setup_.has_motion_sensor = true;
  setup_.odometry.use_lidar = true;
  setup_.odometry.max_wait = from_seconds(0.2);
  setup_.delivery = Delivery::kOverwrite;
  push_sweep(at(0), HostClock::now() - from_seconds(0.5));
  push(StreamItem::Kind::kTick, at(0.3));
  const auto reports = run(at(1));
  const ReportItem& tick = reports[reports.size() - 2];
  ASSERT_EQ(tick.kind, Kind::kTick);
  EXPECT_EQ(tick.skipped_registrations, 0U);
}

TEST_F(FusionThreadTest, AnImageIsMatchedWithTheSweepDuringWhichItWasExposed) {
  push(StreamItem::Kind::kStart, at(0));
  push_image(at(0.04));
  push_image(at(0.14));
  push_sweep(at(0));
  push_sweep(at(0.1));
  const auto reports = run(at(1));
  EXPECT_THAT(kinds(reports), ElementsAre(Kind::kStart, Kind::kSweep, Kind::kFrame, Kind::kSweep,
                                          Kind::kFrame, Kind::kTick, Kind::kEnd));
  for (const size_t i : {2U, 4U}) {
    const FrameReport& frame = reports[i].frame;
    EXPECT_EQ(frame.device, "front");
    EXPECT_STREQ(frame.reason, "");
    EXPECT_EQ(frame.sweep_offset, from_seconds(0.04));
    EXPECT_EQ(frame.points_in_view, 1U);
    EXPECT_EQ(frame.bright, 1);
  }
  EXPECT_EQ(reports[5].counters.cameras[0].used, 2U);
}

TEST_F(FusionThreadTest, ImagesThatCannotBeUsedAreCountedOrReportedWithAReason) {
  push(StreamItem::Kind::kStart, at(0));
  push_image(at(0.01), false);
  push_image(at(0.02), true, 16);
  push_sweep(at(0));
  const auto reports = run(at(1));
  EXPECT_THAT(kinds(reports),
              ElementsAre(Kind::kStart, Kind::kSweep, Kind::kFrame, Kind::kTick, Kind::kEnd));
  EXPECT_STREQ(reports[2].frame.reason, "image size differs from the intrinsics");
  EXPECT_EQ(reports[3].counters.cameras[0].used, 1U);
  EXPECT_EQ(reports[3].counters.cameras[0].refused, 1U);
}

TEST_F(FusionThreadTest, WithoutALidarPosesAreReportedTenTimesASecond) {
  setup_.rig = {};
  setup_.has_odometry = setup_.has_motion_sensor = true;
  push(StreamItem::Kind::kStart, at(0));
  for (int i = 0; i < 100; ++i) {
    StreamItem& item = slot(StreamItem::Kind::kSamples, at(0.02 * i));
    item.samples = {ImuSample{at(0.02 * i), {}, {0, 0, 9.81}},
                    WheelOdometry{at(0.02 * i), {}, 0, 0}};
    items_.publish();
    if (i % 40 == 39) push(StreamItem::Kind::kTick, at(0.02 * i));
  }
  std::vector<Stamp> stamps;
  for (const ReportItem& report : run(at(2))) {
    if (report.kind == Kind::kPose) stamps.push_back(report.pose.stamp);
  }
  EXPECT_NEAR(static_cast<double>(stamps.size()), 20, 2);
  for (size_t i = 1; i < stamps.size(); ++i) {
    EXPECT_GE(stamps[i] - stamps[i - 1], from_seconds(0.1));
  }
}

}  // namespace
}  // namespace infuse::daemon
