#include "tests/study/registration/alignment_table.hpp"

#include <gtest/gtest.h>

#include "drivers/measurement/angles.hpp"
#include "fusion/registration/visual/visual_alignment.hpp"
#include "tests/study/registration/rendered_drive.hpp"

namespace infuse::study {
namespace {

registration::VisualAlignment align(const RenderedDrive& drive, const PosedScan& target,
                                    const PosedScan& source) {
  const auto there = images_of(target, drive.rig.cameras);
  const auto here = images_of(source, drive.rig.cameras);
  return *registration::align_by_keypoints({features::make_sweep_view(target.sweep), there},
                                           {features::make_sweep_view(source.sweep), here});
}

TEST(VisualAlignment, FindsScansOfARingOfCamerasWithoutAGuessOrSaysWhyNot) {
  const auto drive = render_drive(2001, {0, 6, 156});
  ASSERT_TRUE(drive) << drive.error().message();
  const PosedScan &target = drive->scans[0], &source = drive->scans[1];
  const Eigen::Isometry3d truth = target.T_world_lidar.inverse() * source.T_world_lidar;
  const registration::VisualAlignment found = align(*drive, target, source);
  ASSERT_TRUE(found.result.usable()) << found.result.reason;
  EXPECT_GT(found.bootstrap.probability, 0.99);
  EXPECT_LT((found.result.T_target_source.translation() - truth.translation()).norm(), 0.05);
  EXPECT_LT(
      geometry::rotation_log(found.result.T_target_source.linear() * truth.linear().transpose())
          .norm(),
      0.05 * kDegree);
  // The pair 6 m apart on one street: what the front camera shows, it showed before.
  EXPECT_EQ(found.consensus(0, 0), 1);

  // The same scan seen by a rig that is turned by one camera: every camera sees its neighbour's
  // view, and the consensus matrix says so.
  PosedScan turned = source;
  std::rotate(turned.images.begin(), turned.images.begin() + 1, turned.images.end());
  const Eigen::Isometry3f T(  // the ring's axis is the lidar's z axis
      Eigen::AngleAxisf(-2 * std::numbers::pi_v<float> / 5, Eigen::Vector3f::UnitZ()));
  for (size_t i = 0; i < turned.sweep.size(); ++i) {
    const Eigen::Vector3f p =
        T * Eigen::Vector3f(turned.sweep.x[i], turned.sweep.y[i], turned.sweep.z[i]);
    turned.sweep.x[i] = p.x();
    turned.sweep.y[i] = p.y();
    turned.sweep.z[i] = p.z();
  }
  const registration::VisualAlignment about = align(*drive, target, turned);
  ASSERT_TRUE(about.result.usable()) << about.result.reason;
  EXPECT_EQ(about.consensus(1, 0), 1);
  const Eigen::Isometry3d turned_truth = truth * T.inverse().cast<double>();
  EXPECT_LT((about.result.T_target_source.translation() - turned_truth.translation()).norm(), 0.05);

  // Another street.
  const registration::VisualAlignment elsewhere = align(*drive, target, drive->scans[2]);
  EXPECT_FALSE(elsewhere.result.usable());
  EXPECT_STRNE(elsewhere.result.reason, "");
}

}  // namespace
}  // namespace infuse::study
