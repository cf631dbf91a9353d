#include "fusion/target/initial_board_pose.hpp"

#include <opencv2/calib3d.hpp>
#include <vector>

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::target {
namespace {

constexpr double kMinCosine = 0.087;  // of 85°: a board that fills 170°, derived from the plane's
                                      // tangents, which grow beyond all bounds at 90°

/// Directions of the corners, camera frame.
std::optional<std::vector<Eigen::Vector3d>> unproject_corners(const geometry::CameraModel& camera,
                                                              const Corners& corners) {
  std::vector<Eigen::Vector3d> rays;
  for (const Eigen::Vector2d& corner : corners) {
    const auto ray = camera.unproject(corner);
    if (!ray) return std::nullopt;
    rays.push_back(*ray);
  }
  return rays;
}

}  // namespace

std::optional<Eigen::Isometry3d> estimate_initial_board_pose(const geometry::CameraModel& camera,
                                                             const Board& board,
                                                             const Corners& corners) {
  const auto rays = unproject_corners(camera, corners);
  if (!rays || rays->size() != board.corner_count()) return std::nullopt;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& ray : *rays) mean += ray;
  const Eigen::Matrix3d ahead =
      Eigen::Quaterniond::FromTwoVectors(mean, Eigen::Vector3d::UnitZ()).toRotationMatrix();

  std::vector<cv::Point3d> on_board;
  std::vector<cv::Point2d> observed;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d ray = ahead * (*rays)[i];
    if (!(ray.z() > kMinCosine)) return std::nullopt;
    const Eigen::Vector3d corner = board.corner(i) - board.middle();
    on_board.emplace_back(corner.x(), corner.y(), corner.z());
    observed.emplace_back(ray.x() / ray.z(), ray.y() / ray.z());
  }
  cv::Mat rvec, tvec;
  try {
    if (!cv::solvePnP(on_board, observed, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), rvec, tvec,
                      false, cv::SOLVEPNP_IPPE)) {
      return std::nullopt;
    }
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = geometry::rotation_exp({rvec.at<double>(0), rvec.at<double>(1), rvec.at<double>(2)});
  T.translation() = Eigen::Vector3d(tvec.at<double>(0), tvec.at<double>(1), tvec.at<double>(2)) -
                    T.linear() * board.middle();
  T = Eigen::Isometry3d(ahead.transpose()) * T;
  if (!T.matrix().allFinite()) return std::nullopt;
  for (size_t i = 0; i < corners.size(); ++i) {
    if (!camera.project(T * board.corner(i))) return std::nullopt;
  }
  return T;
}

}  // namespace infuse::target
