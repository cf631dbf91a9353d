#include "fusion/registration/visual/visual_alignment.hpp"

#include <gtest/gtest.h>

#include "tests/fusion/registration/random_room.hpp"
#include "tests/fusion/registration/visual/small_camera.hpp"

namespace infuse::registration {
namespace {

// Simulated scans are aligned in tests/study/registration.

/// A room with a camera that shows nothing.
struct BlankScan {
  CameraMount camera = small_camera();
  CameraFrame frame;
  Sweep sweep;

  BlankScan() {
    const CameraIntrinsics& k = camera.intrinsics;
    frame.width = k.width;
    frame.height = k.height;
    frame.pixels.assign(160 * 120, 90);
    const PointCloud room = random_room(1, 4000, 0.01, Eigen::Isometry3d::Identity());
    sweep.x = room.x;
    sweep.y = room.y;
    sweep.z = room.z;
  }
};

TEST(VisualAlignment, ImagesWithoutKeypointsAreRefused) {
  const BlankScan scan;
  const std::vector<ScanImage> images{{scan.frame, scan.camera}};
  const CameraLidarScan view{features::make_sweep_view(scan.sweep), images};
  const auto found = align_by_keypoints(view, view);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_EQ(found->matches, 0U);
  EXPECT_STREQ(found->result.reason, "the images have too little in common");
}

TEST(VisualAlignment, ScansOfTwoRigsAreRefused) {
  const BlankScan scan;
  const std::vector<ScanImage> images{{scan.frame, scan.camera}};
  const auto sweep = features::make_sweep_view(scan.sweep);
  EXPECT_FALSE(align_by_keypoints({sweep, images}, {sweep, {}}));
  const auto none = align_by_keypoints({sweep, {}}, {sweep, {}});
  ASSERT_TRUE(none);
  EXPECT_FALSE(none->result.usable());
}

TEST(VisualAlignment, OptionsAreChecked) {
  EXPECT_FALSE(VisualAlignmentOptions{}.invalid());
  EXPECT_TRUE(VisualAlignmentOptions{.keypoint_radius = 9}.invalid());
  EXPECT_TRUE(VisualAlignmentOptions{.max_ratio = 0}.invalid());
  EXPECT_TRUE(VisualAlignmentOptions{.min_agreement = 1}.invalid());
}

}  // namespace
}  // namespace infuse::registration
