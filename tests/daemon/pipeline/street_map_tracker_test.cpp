#include "daemon/pipeline/street_map_tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "daemon/protocol/messages.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/fusion/streetmap/town.hpp"

namespace infuse::daemon {
namespace {

using streetmap::PlanarPose;
using streetmap::SegmentKind;
using streetmap::TrackState;

/// A town, a drive along its street with exact odometry, and sweeps of the ground around.
class StreetMapTrackerTest : public testing::Test {
 protected:
  static constexpr Duration kStep{250'000'000};  // between sweeps

  Eigen::Isometry3d pose_at(Stamp stamp) const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation().x() = -90 + 5 * to_seconds(stamp - start_);
    T.translation().y() = -1.3;
    return T;
  }

  StreetMapTrackerTest() {
    rig_.lidars.push_back({"top", "", Eigen::Isometry3d::Identity()});
    rig_.lidars[0].T_vehicle_lidar.translation().z() = 1.7;
    // The frame odom begins at the start of the drive.
    const Eigen::Isometry3d T_odom_map = pose_at(start_).inverse();
    for (int i = 0; i <= 1200; ++i) {
      const Stamp stamp = start_ + i * Duration(20'000'000);
      trajectory_.append({stamp, T_odom_map * pose_at(stamp)});
    }
    settings_.tracker.particles.max_count = 300;
    settings_.tracker.grid.max_samples = 600;
    settings_.tracker.grid.extent = 30;
  }

  /// Makes a sweep of the surroundings: reflectivity and height depend on the kind of ground.
  void scan(Stamp stamp, uint64_t seed) {
    sweep_.clear();
    sweep_.rings = 1;
    sweep_.stamp = stamp;
    sweep_.resize(2500);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> place(-15, 15);
    std::normal_distribution<double> noise;
    const Eigen::Isometry3d T = pose_at(stamp);
    for (size_t i = 0; i < sweep_.size(); ++i) {
      const Eigen::Vector3d p(place(random), place(random), 0);
      const Eigen::Vector3d q = T * p;
      const auto kind = town_.map.segment(town_.map.id_at(q.x(), q.y())).kind;
      const bool wall = kind == SegmentKind::kWall || kind == SegmentKind::kBuilding;
      const double height = wall ? 1.5 : kind == SegmentKind::kCarriageway ? 0 : 0.12;
      const double bright = kind == SegmentKind::kCarriageway ? 0.2
                            : kind == SegmentKind::kSidewalk  ? 0.5
                                                              : 0.35;
      sweep_.x[i] = static_cast<float>(p.x());
      sweep_.y[i] = static_cast<float>(p.y());
      sweep_.z[i] = static_cast<float>(height + 0.02 * noise(random) - 1.7);
      sweep_.range[i] = static_cast<float>(std::hypot(p.norm(), 1.7));
      sweep_.reflectivity[i] = static_cast<float>(bright + 0.06 * noise(random));
      sweep_.ring[i] = 0;
      sweep_.column[i] = static_cast<uint16_t>(2 * i);
    }
    deskewed_.reference = stamp;
    deskewed_.x = sweep_.x;
    deskewed_.y = sweep_.y;
    deskewed_.z = sweep_.z;
  }

  PoseReport drive(StreetMapTracker& tracker, int sweeps, const PoseReport& odometry = {}) {
    PoseReport pose;
    for (int i = 0; i < sweeps; ++i) {
      now_ = start_ + i * kStep;
      scan(now_, static_cast<uint64_t>(i));
      pose = tracker.process({LidarIndex(0), sweep_, deskewed_}, trajectory_, {}, odometry);
    }
    return pose;
  }

  /// A fix at the true pose, off by `offset` (m).
  GnssFix fix_at(Stamp stamp, const Eigen::Vector2d& offset, double hdop) const {
    const Eigen::Vector3d at = pose_at(stamp).translation();
    const auto& frame = town_.map.frame();
    const Eigen::Vector3d place =
        gnss::to_geodetic(gnss::make_local_frame(frame.latitude, frame.longitude),
                          {at.x() + offset.x(), at.y() + offset.y(), 0});
    GnssFix fix;
    fix.stamp = stamp;
    fix.latitude = place.x();
    fix.longitude = place.y();
    fix.course = M_PI / 2;  // clockwise from north: east
    fix.speed = 5;
    fix.hdop = hdop;
    fix.valid = true;
    return fix;
  }

  double error(const PoseReport& report) const {
    return (report.T_frame_vehicle.translation() - pose_at(now_).translation()).norm();
  }

  Stamp start_ = Stamp::from_ns(1'000'000'000'000);
  Stamp now_ = start_;
  streetmap::town::Town town_ = streetmap::town::build(streetmap::town::plan());
  StreetMapFile map_{{}, town_.map, {}};
  Rig rig_;
  geometry::Trajectory trajectory_;
  StreetMapSettings settings_;
  Sweep sweep_;
  motion::DeskewedSweep deskewed_;
};

TEST_F(StreetMapTrackerTest, ReportsThePoseOnTheMap) {
  settings_.initial_pose = InitialPose{-89, -2.5, 0.03};
  StreetMapTracker tracker(settings_, map_, rig_);
  PoseReport odometry;
  odometry.speed = 5;
  const PoseReport pose = drive(tracker, 60, odometry);
  EXPECT_EQ(pose.frame, PoseFrame::kMap);
  ASSERT_TRUE(pose.map);
  EXPECT_EQ(pose.map->state, TrackState::kTracking);
  EXPECT_TRUE(pose.usable());
  EXPECT_LT(error(pose), 0.6);
  EXPECT_EQ(pose.speed, 5);
  EXPECT_TRUE(is_valid_message(message(pose)));
  const StreetMapStatus status = tracker.status();
  EXPECT_EQ(status.state, TrackState::kTracking);
  EXPECT_FALSE(status.mismatch);
  EXPECT_NEAR(status.x, pose.T_frame_vehicle.translation().x(), 1e-9);
  // 60 sweeps in 14.75 s at two a second.
  EXPECT_EQ(status.updates, 30U);
}

TEST_F(StreetMapTrackerTest, InitialisesFromSeveralGnssFixes) {
  StreetMapTracker tracker(settings_, map_, rig_);
  drive(tracker, 1);
  PoseReport odometry;
  EXPECT_FALSE(tracker.pose(odometry).usable());
  EXPECT_STREQ(tracker.pose(odometry).reason, "no initial pose");
  EXPECT_TRUE(is_valid_message(message(tracker.pose(odometry))));
  // Diluted fixes first, and one outlier among the good ones.
  for (int i = 0; i < 40; ++i) {
    const Stamp stamp = start_ + i * kStep;
    const double off = i < 15 ? 20 : i == 18 ? -80 : 0;
    tracker.add_gnss(fix_at(stamp, {off, 1}, i < 15 ? 15 : 1));
    now_ = stamp;
    scan(now_, static_cast<uint64_t>(i));
    tracker.process({LidarIndex(0), sweep_, deskewed_}, trajectory_, {}, odometry);
    if (i < 19) {
      EXPECT_TRUE(std::string_view(tracker.pose(odometry).reason).starts_with("no initial pose"))
          << i;
    }
  }
  const PoseReport started = tracker.pose(odometry);
  EXPECT_TRUE(started.usable());
  EXPECT_LT(error(started), 2);
  ASSERT_TRUE(tracker.status().gnss_offset);
  EXPECT_LT(tracker.status().gnss_offset->norm(), 3);
  EXPECT_GT(tracker.status().gnss_offset_sigma, 0);
  EXPECT_NEAR(std::atan2(tracker.pose(odometry).T_frame_vehicle(1, 0),
                         tracker.pose(odometry).T_frame_vehicle(0, 0)),
              0, 0.05);
}

TEST_F(StreetMapTrackerTest, ALocationStartsItAndIsNotUsableBeforeTracking) {
  const GnssFix place = fix_at(start_, {0, 0}, 1);
  settings_.initial_location = InitialLocation{place.latitude, place.longitude, M_PI / 2};
  StreetMapTracker tracker(settings_, map_, rig_);
  const PoseReport first = drive(tracker, 1);
  EXPECT_LT(error(first), 1.5);
  EXPECT_EQ(first.map->state, TrackState::kUnsure);
  EXPECT_FALSE(first.usable());
  EXPECT_STREQ(first.reason, first.map->reason);
  EXPECT_TRUE(is_valid_message(message(first)));
  settings_.require_tracking = false;
  StreetMapTracker lenient(settings_, map_, rig_);
  const PoseReport unsure = drive(lenient, 1);
  EXPECT_TRUE(unsure.usable());
  EXPECT_EQ(unsure.map->state, TrackState::kUnsure);
  EXPECT_STRNE(unsure.map->reason, "");
}

TEST_F(StreetMapTrackerTest, AGapInOdometryWidensTheParticles) {
  settings_.initial_pose = InitialPose{-90, -1.3, 0};
  settings_.initial_sigma = 0.1;
  StreetMapTracker tracker(settings_, map_, rig_);
  drive(tracker, 1);
  const geometry::Trajectory empty;
  deskewed_.reference = start_ + kStep;
  deskewed_.reason = "the trajectory has a gap";
  geometry::PoseAt predicted{.T_odom_vehicle = pose_at(start_ + kStep)};
  predicted.covariance(3, 3) = 9;
  const PoseReport pose = tracker.process({LidarIndex(0), sweep_, deskewed_}, empty, predicted, {});
  // Variance of x itself: a left perturbation rotates about the map origin.
  const auto& C = pose.covariance;
  const double y = pose.T_frame_vehicle(1, 3);
  EXPECT_GT(C(3, 3) - 2 * y * C(2, 3) + y * y * C(2, 2), 4);
}

// On a map whose origin is another, the vehicle is where it was on the earth.
TEST_F(StreetMapTrackerTest, GoesOnOnAnotherMap) {
  settings_.initial_pose = InitialPose{-90, -1.3, 0};
  StreetMapTracker before(settings_, map_, rig_);
  const PoseReport last = drive(before, 4);
  const streetmap::MapFrame& frame = map_.map.frame();
  const auto old_origin = gnss::make_local_frame(frame.latitude, frame.longitude);
  const double latitude = frame.latitude + 3e-4, longitude = frame.longitude - 2e-3;
  streetmap::SegmentMapWriter writer({true, latitude, longitude, 0.2, {-500, -500}}, 1, 1);
  const auto bytes = std::make_shared<const std::vector<std::byte>>(
      writer.finish(std::vector<streetmap::Segment>(1), "").value());
  settings_.initial_pose.reset();
  StreetMapTracker next(settings_, {{}, streetmap::SegmentMap::open(*bytes, "").value(), {}}, rig_);
  next.go_on_from(before);
  ASSERT_TRUE(next.started());
  const Eigen::Isometry3d T = next.pose({}).T_frame_vehicle,
                          T_before = before.pose({}).T_frame_vehicle;
  const auto on_earth = [](const gnss::LocalFrame& local,
                           const Eigen::Vector3d& at) -> Eigen::Vector3d {
    return gnss::to_geodetic(local, {at.x(), at.y(), 0});
  };
  const auto new_origin = gnss::make_local_frame(latitude, longitude);
  for (const double ahead : {0.0, 50.0}) {
    const Eigen::Vector3d is = on_earth(new_origin, T * Eigen::Vector3d(ahead, 0, 0));
    const Eigen::Vector3d was = on_earth(old_origin, T_before * Eigen::Vector3d(ahead, 0, 0));
    constexpr double kEarth = 6.4e6;                                // m
    EXPECT_LT((is - was).head<2>().norm() * kEarth, 1.0) << ahead;  // particles are drawn anew
  }
  EXPECT_FALSE(last.map->state == TrackState::kLost);
  // From a map that has no latitude and longitude there is no way to one that has.
  StreetMapTracker other(settings_, map_, rig_);
  StreetMapFile image = map_;
  streetmap::SegmentMapWriter plain({false, 0, 0, 0.2, {0, 0}}, 1, 1);
  const auto plain_bytes = plain.finish(std::vector<streetmap::Segment>(1), "").value();
  image.map = streetmap::SegmentMap::open(plain_bytes, "").value();
  StreetMapTracker of_image(settings_, image, rig_);
  other.go_on_from(of_image);
  EXPECT_FALSE(other.started());
}

TEST(StreetMapSettings, InvalidSettingsAreErrors) {
  EXPECT_FALSE(StreetMapSettings().invalid());
  EXPECT_TRUE((StreetMapSettings{.initial_pose = InitialPose{INFINITY, 0, 0}}).invalid());
  EXPECT_TRUE(StreetMapSettings{.initial_sigma = 0}.invalid());
  EXPECT_TRUE(StreetMapSettings{.update_hz = 0}.invalid());
}

TEST(StreetMapHealth, RaisesFindingsWithThePosition) {
  HealthOptions options;
  options.raise_after = options.clear_after = Duration::zero();
  AlertChecks<StreetMapStatus> health(streetmap_alerts(), options);
  StreetMapStatus status{.state = TrackState::kLost,
                         .reason = "x",
                         .mismatch = true,
                         .on_map = true,
                         .x = 120.4,
                         .y = -33};
  const auto& conditions = health.update(Stamp::from_ns(1), status);
  ASSERT_EQ(conditions.findings().size(), 2U);
  EXPECT_STREQ(conditions.findings()[0].id, "lost");
  EXPECT_STREQ(conditions.findings()[1].id, "map_mismatch");
  EXPECT_NE(conditions.findings()[1].what.find("120 m east, -33 m north"), std::string::npos);
  status = {.state = TrackState::kLost, .reason = "no initial pose"};
  health.update(Stamp::from_ns(2), status);
  EXPECT_EQ(conditions.findings()[0].what, "position on the street map lost: no initial pose");
  status.places.add({.probability = 0.6});
  status.places.add({.probability = 0.4});
  health.update(Stamp::from_ns(2), status);
  EXPECT_EQ(conditions.findings()[0].what,
            "position on the street map lost: no initial pose; it is at one of 2 places: 60, 40 %");
  status = {.state = TrackState::kUnsure,
            .gnss_contradicts = true,
            .gnss_offset = Eigen::Vector2d(30, -40)};
  health.update(Stamp::from_ns(3), status);
  ASSERT_EQ(conditions.findings().size(), 1U);
  EXPECT_EQ(conditions.findings()[0].what, "GNSS fixes are 50 m off the pose on the street map");
  status = {.state = TrackState::kTracking};
  health.update(Stamp::from_ns(4), status);
  EXPECT_TRUE(conditions.findings().empty());
}

}  // namespace
}  // namespace infuse::daemon
