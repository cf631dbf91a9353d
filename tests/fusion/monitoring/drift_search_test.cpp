#include "fusion/monitoring/drift_search.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "drivers/measurement/angles.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::monitoring {
namespace {

using calibration::painted::small_camera;
using calibration::painted::true_T_camera_lidar;
using geometry::Vector6;

constexpr double kNoise = 0.006;  // nats, as the detector has it on simulated streets

constexpr size_t kPlaces = 6;

struct Place {
  calibration::painted::World world;
  Sweep sweep;
  CameraFrame grey;  // by a camera whose stamps are right
  Motion motion;
};

const std::vector<Place>& all_places() {
  static const std::vector<Place> all = [] {
    std::vector<Place> made;
    for (uint64_t k = 0; k < kPlaces; ++k) {
      const auto world = calibration::painted::make_world(k + 1);
      const double turn = k % 2 == 0 ? 0.3 : -0.2;  // rad/s
      made.push_back(
          {world, calibration::painted::scan(world, 100 + k),
           calibration::painted::render_image(world, small_camera(), true_T_camera_lidar()),
           Motion{.angular_rate = {0, turn, 0}, .velocity = {0, 0, 5}}});
    }
    return made;
  }();
  return all;
}

/// Adds the places as seen by a camera with late stamps, under a calibration.
class Places {
 public:
  Places(DriftSearch& search, const Eigen::Isometry3d& T_camera_lidar, double delay = 0) {
    MonitorImage image;
    MonitorPoints points;
    features::RingDirections rings;
    features::find_ring_directions(camera_, T_camera_lidar, 1, rings);
    for (const Place& place : all_places()) {
      Vector6 twist;
      twist << place.motion.angular_rate, place.motion.velocity;
      image.build(delay == 0 ? place.grey
                             : calibration::painted::render_image(
                                   place.world, small_camera(),
                                   geometry::exp(delay * twist) * true_T_camera_lidar()),
                  1, rings);
      points.select(make_sweep_view(place.sweep), camera_, T_camera_lidar, 8000);
      search.add(image.compared().fine, points.compared(), place.motion);
    }
  }
  const geometry::CameraModel& camera() const { return camera_; }

 private:
  geometry::CameraModel camera_{small_camera()};
};

Eigen::Isometry3d knocked(const Vector6& by) { return geometry::exp(by) * true_T_camera_lidar(); }

TEST(DriftSearch, FindsAKnockAboutAnyAxisWithItsAmount) {
  for (const Eigen::Vector3d& degrees : {Eigen::Vector3d(0, -5, 0), Eigen::Vector3d(2, 3, -1)}) {
    Vector6 by = Vector6::Zero();
    by.head<3>() = degrees * kDegree;
    DriftSearch search({});
    const Places places(search, knocked(by));
    const DriftEstimate found =
        search.find(knocked(by), std::nullopt, kPlaces, kNoise, places.camera());
    const Vector6 error = geometry::log(geometry::exp(found.moved) * geometry::exp(by));
    EXPECT_LT(error.head<3>().norm(), 0.25 * kDegree) << degrees.transpose();
    EXPECT_LT(error.tail<3>().norm(), 0.1) << degrees.transpose();
    EXPECT_LT(std::sqrt(found.covariance(1, 1)), 0.5 * kDegree);
    EXPECT_FALSE(found.at_least);
  }
}

TEST(DriftSearch, NamesTheAxisThatExplainsMost) {
  for (const int axis : {2, 3}) {
    const Vector6 by = (axis < 3 ? 1.5 * kDegree : 0.15) * Vector6::Unit(axis);
    DriftSearch search({});
    const Places places(search, knocked(by));
    const DriftEstimate found =
        search.find(knocked(by), std::nullopt, kPlaces, kNoise, places.camera());
    EXPECT_EQ(found.likeliest(), static_cast<Axis>(axis));
  }
}

TEST(DriftSearch, LateStampsExplainWhatTurnsGive) {
  constexpr double kDelay = -0.08;  // s
  DriftSearch search({});
  const Places places(search, true_T_camera_lidar(), kDelay);
  const DriftEstimate found =
      search.find(true_T_camera_lidar(), std::nullopt, kPlaces, kNoise, places.camera());
  EXPECT_EQ(found.likeliest(), Axis::kTime);
  EXPECT_NEAR(found.delay, kDelay, 0.03);
}

TEST(DriftSearch, FollowsAKnownPoseAndAllocatesNothing) {
  const Vector6 by = 4 * kDegree * Vector6::Unit(1);
  DriftSearch search({});
  const Places places(search, knocked(by));
  const DriftEstimate first =
      search.find(knocked(by), std::nullopt, kPlaces, kNoise, places.camera());
  const size_t before = allocation_count();
  const DriftEstimate again =
      search.find(knocked(by), first.moved, kPlaces, kNoise, places.camera());
  EXPECT_EQ(allocation_count(), before);
  EXPECT_LT((again.moved - first.moved).head<3>().norm(), 0.2 * kDegree);
}

TEST(DriftSearch, AStoppedOneComparesNothing) {
  DriftSearch search({});
  const Places places(search, knocked(4 * kDegree * Vector6::Unit(1)));
  std::stop_source stop;
  stop.request_stop();
  const DriftEstimate found = search.find(true_T_camera_lidar(), std::nullopt, kPlaces, kNoise,
                                          places.camera(), stop.get_token());
  EXPECT_EQ(found.gain, DriftEstimate().gain);
}

}  // namespace
}  // namespace infuse::monitoring
