#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fusion/calibration/scene.hpp"
#include "fusion/calibration/visible_points.hpp"

namespace infuse::calibration {

/// Settings of a comparison of two extrinsics.
struct CompareOptions {
  double sigma = 2;           ///< px, blur of the images, I 4.3.1.4; see `ImageBlur`
  double max_p_value = 0.05;  ///< of a difference that is taken for real (decision 8)
  /// px: the measures may be largest so far beside the truth, as with the principal point so far
  /// off (decision 8).
  double bias = 0.5;
  uint64_t seed = 1;             ///< of the drawn signs
  VisibilityOptions visibility;  ///< of the points, in view under both poses

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// How well a scene fits one pose.
struct SceneFit {
  double edge_gradient = 0;  ///< mean rank of the image's gradient at depth edges, 0 … 1
  double dependence = 0;     ///< the default measure, nats
};

/// Comparison of two poses a and b on the same points.
struct ExtrinsicComparison {
  std::vector<SceneFit> a, b;  ///< one per scene that was compared
  std::vector<size_t> scenes;  ///< their indices
  SceneFit mean_a, mean_b;     ///< over these
  size_t independent = 0;      ///< number of groups of scenes that are not of one place
  double p_value = 1;          ///< of so large a difference between equal poses, two-sided
  double bias_share = 0;       ///< of `better`, what `CompareOptions::bias` can feign; 1: all of it
  double better = 0;           ///< sum of the scaled differences: positive where b fits better
  std::string reason;          ///< why nothing can be said; empty if it can

  bool usable() const { return reason.empty(); }  ///< it may be used
};

/// Compares two poses T_refcam_lidar on scenes that neither was estimated from: by the image's
/// gradient at the lidar's depth edges and by the dependence between lidar and image. Per scene the
/// two differences, each divided by its root mean square over the scenes, are added. Between
/// equally good poses their signs are random, so the p-value is the share of sign patterns whose
/// sum is as large (permutation test; Fisher 1935). Scenes of one place share a sign.
///
/// The scenes have a bias in common, which no permutation of them shows: of two poses as far to
/// either side of the truth it names one, surely. So the p-value is that of the differences with
/// the principal point moved by `bias` in the direction that makes the poses most alike, and 1
/// where the sum changes its sign within that. The derivatives by the principal point are
/// differences.
///
/// Scenes must have the features of the default measure (`named_measures`). Not usable with fewer
/// than 6 independent scenes: five equal signs come by chance in one of 16.
ExtrinsicComparison compare_extrinsics(std::span<const Scene> scenes,
                                       std::span<const RigCamera> cameras,
                                       const Eigen::Isometry3d& T_refcam_lidar_a,
                                       const Eigen::Isometry3d& T_refcam_lidar_b,
                                       const CompareOptions& options);

/// Groups scenes that are of one place: the group of each, numbered from 0. Two scenes share a
/// group if a chain of scenes whose `similarity` exceeds 0.5 leads from one to the other.
std::vector<size_t> group_similar(const Eigen::MatrixXd& similarity);

/// Share of sign patterns whose sum is at least as large as that of `values`, in absolute value:
/// all patterns of up to 16 values, 20 000 drawn ones of more.
double sign_permutation_p_value(std::span<const double> values, uint64_t seed);

}  // namespace infuse::calibration
