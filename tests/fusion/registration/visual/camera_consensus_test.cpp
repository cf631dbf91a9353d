#include "fusion/registration/visual/camera_consensus.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

namespace infuse::registration {
namespace {

/// Cameras that face outwards in a ring, counter-clockwise, camera 0 forward.
std::vector<CameraMount> ring(int count, double focal_length) {
  Eigen::Matrix3d forward;  // camera axes of a camera that faces along x
  forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  std::vector<CameraMount> cameras;
  for (int k = 0; k < count; ++k) {
    CameraMount camera;
    camera.intrinsics.width = 640;
    camera.intrinsics.height = 480;
    camera.intrinsics.fx = camera.intrinsics.fy = focal_length;
    camera.intrinsics.cx = 319.5;
    camera.intrinsics.cy = 239.5;
    Eigen::Isometry3d T_lidar_camera = Eigen::Isometry3d::Identity();
    T_lidar_camera.linear() =
        Eigen::AngleAxisd(2 * std::numbers::pi * k / count, Eigen::Vector3d::UnitZ())
            .toRotationMatrix() *
        forward;
    camera.T_camera_lidar = T_lidar_camera.inverse();
    cameras.push_back(camera);
  }
  return cameras;
}

bool contains(const std::vector<ConsensusMatrix>& all, const ConsensusMatrix& matrix) {
  return std::find(all.begin(), all.end(), matrix) != all.end();
}

/// The identity with its rows moved down, as P fig. 4.8.
ConsensusMatrix shifted(int count, int rows) {
  ConsensusMatrix matrix = ConsensusMatrix::Zero(count, count);
  for (int j = 0; j < count; ++j) matrix((j + rows) % count, j) = 1;
  return matrix;
}

TEST(CameraConsensus, ARingOfFiveHasItsTurnsAmongTheIdealMatrices) {
  const auto cameras = ring(5, 440);  // 72° each: hardly any overlap
  const auto ideal = ideal_consensus(cameras);
  for (int rows = 0; rows < 5; ++rows) EXPECT_TRUE(contains(ideal, shifted(5, rows))) << rows;
  for (const ConsensusMatrix& matrix : ideal) {
    EXPECT_TRUE((matrix.array() == 0 || matrix.array() == 1).all());
    EXPECT_GT(matrix.sum(), 0);
  }
}

TEST(CameraConsensus, ThesisExampleIsTheTurnByOneCamera) {
  // P fig. 4.9: the measured matrix and its closest hypothesis.
  ConsensusMatrix measured(5, 5), expected(5, 5);
  measured << 0.7386, 0.3669, 0.2658, 0.5588, 1,  //
      1, 0.6307, 0.3590, 0.4303, 0.4800,          //
      0.6266, 1, 0.5160, 0.7388, 0.7482,          //
      0.4475, 0.5219, 1, 0.5846, 0.2976,          //
      0.6395, 0.3719, 0.2865, 0.6600, 1;
  expected = shifted(5, 1);
  const std::vector<ConsensusMatrix> turns = {shifted(5, 0), shifted(5, 1), shifted(5, 2),
                                              shifted(5, 3), shifted(5, 4)};
  EXPECT_EQ(turns[nearest_consensus(measured, turns)], expected);
}

TEST(CameraConsensus, AForwardMoveLetsTheFrontCamerasShareTheirViews) {
  // What the side camera saw ahead of it is beside or behind it after a move; some matrix says so.
  const auto ideal = ideal_consensus(ring(5, 330));
  EXPECT_TRUE(std::any_of(ideal.begin(), ideal.end(), [](const ConsensusMatrix& matrix) {
    return matrix(0, 0) == 1 && matrix(0, 1) + matrix(0, 4) + matrix(1, 0) + matrix(4, 0) > 0;
  }));
}

TEST(CameraConsensus, ASingleCameraHasOneMatrix) {
  const auto ideal = ideal_consensus(ring(1, 700));
  ASSERT_EQ(ideal.size(), 1U);
  EXPECT_EQ(ideal.front(), ConsensusMatrix::Ones(1, 1));
}

TEST(CameraConsensus, RowsAreScaledToOneAndEmptyRowsStay) {
  ConsensusMatrix measured(2, 2);
  measured << 2, 8, 0, 0;
  ConsensusMatrix expected(2, 2);
  expected << 0.25, 1, 0, 0;
  EXPECT_EQ(normalise_rows(measured), expected);
}

}  // namespace
}  // namespace infuse::registration
