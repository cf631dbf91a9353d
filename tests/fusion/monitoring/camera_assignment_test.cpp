#include "fusion/monitoring/camera_assignment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/camera/colour.hpp"
#include "fusion/monitoring/reduced_image.hpp"
#include "tests/fusion/calibration/nuscenes_instant.hpp"
#include "tests/real_data.hpp"

namespace infuse::monitoring {
namespace {

constexpr double kFocalLength = 300;  // samples
constexpr size_t kMaxPoints = 8000;
constexpr double kNoise = 0.02;  // nats per return, of the order of a detector's

/// A real rig of six cameras and one sweep.
class RealRig {
 public:
  explicit RealRig(const std::filesystem::path& folder) : instant_(nuscenes::read_instant(folder)) {
    for (const nuscenes::Shot& shot : instant_.shots) {
      placed_.push_back({shot.name, shot.intrinsics, 0, shot.T_camera_lidar});
    }
  }

  size_t size() const { return placed_.size(); }
  const std::string& name(size_t camera) const { return placed_[camera].name; }

  /// Names of the cameras whose images the cameras seem to deliver, where camera k delivers the
  /// shot `images[k]`. The cameras are configured at the places of `configured`, if given, and then
  /// calibrated to their own.
  std::vector<std::string> images_of(const std::vector<size_t>& images,
                                     const std::vector<size_t>& configured = {}) const {
    const DriftDetectorOptions soon{.false_alarm_hours = 1e-3};  // 5 nats
    std::vector<PlacedCamera> rig = placed_;
    for (size_t k = 0; k < configured.size(); ++k) {
      rig[k].T_camera_lidar = placed_[configured[k]].T_camera_lidar;
    }
    CameraAssignment assignment(rig, soon, {}, kMaxPoints);
    for (size_t k = 0; k < configured.size(); ++k) {
      assignment.set_place(k, placed_[k].T_camera_lidar);
    }
    const SweepView sweep = make_sweep_view(instant_.sweep);
    std::vector<MonitorImage> seen(size());
    std::vector<MonitorPoints> points(size());
    std::vector<double> own(size());
    for (size_t k = 0; k < size(); ++k) {
      const geometry::CameraModel model(placed_[k].intrinsics);
      const int step = reduction_step(placed_[k].intrinsics, kFocalLength);
      features::RingDirections rings;
      features::find_ring_directions(model, placed_[k].T_camera_lidar, step, rings);
      CameraFrame grey;
      camera::to_grey(instant_.shots[images[k]].frame, grey);
      seen[k].build(grey, step, rings);
      points[k].select(sweep, model, placed_[k].T_camera_lidar, kMaxPoints);
      own[k] = MonitorDependence({}).evaluate(placed_[k].T_camera_lidar, seen[k].compared().fine,
                                              points[k].compared(), model);
    }
    constexpr size_t kRounds = 7;  // of 0.85 nats each, for each of five others
    for (size_t round = 0; round < kRounds * (size() - 1); ++round) {
      for (size_t k = 0; k < size(); ++k) {
        assignment.add(k, seen[k].compared().fine, sweep, own[k], points[k], kNoise);
      }
    }
    std::vector<std::string> found;
    for (size_t k = 0; k < size(); ++k) found.push_back(assignment.images_of(k));
    return found;
  }

 private:
  nuscenes::Instant instant_;
  std::vector<PlacedCamera> placed_;
};

TEST(RealCameraAssignment, EveryPairOfSixThatIsSwappedIsNamedAndNoOther) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "calibration/nuscenes");
  const RealRig rig(folder);
  ASSERT_EQ(rig.size(), 6U);
  std::vector<size_t> right(rig.size());
  for (size_t k = 0; k < rig.size(); ++k) right[k] = k;
  EXPECT_EQ(rig.images_of(right), std::vector<std::string>(rig.size()));
  for (size_t a = 0; a < rig.size(); ++a) {
    for (size_t b = 0; b < a; ++b) {
      std::vector<size_t> images = right;
      std::swap(images[a], images[b]);
      std::vector<std::string> expected(rig.size());
      expected[a] = rig.name(b);
      expected[b] = rig.name(a);
      EXPECT_EQ(rig.images_of(images), expected) << rig.name(a) << " " << rig.name(b);
      // Places that were exchanged in the configuration, and calibrated since.
      EXPECT_EQ(rig.images_of(right, images), std::vector<std::string>(rig.size()));
    }
  }
  std::vector<size_t> ring = right;  // three in a ring
  ring[0] = 1;
  ring[1] = 2;
  ring[2] = 0;
  const auto found = rig.images_of(ring);
  for (size_t k = 0; k < rig.size(); ++k) {
    EXPECT_EQ(found[k] == "", k > 2);
    EXPECT_THAT(found[k], testing::HasSubstr(k < 3 ? rig.name(ring[k]) : ""));
  }
}

}  // namespace
}  // namespace infuse::monitoring
