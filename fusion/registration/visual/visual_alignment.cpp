#include "fusion/registration/visual/visual_alignment.hpp"

#include <algorithm>

#include "fusion/registration/refine.hpp"
#include "fusion/registration/view_agreement.hpp"

namespace infuse::registration {
namespace {

/// Keypoints of one camera.
struct CameraKeypoints {
  std::vector<Eigen::Vector3d> points;  // m, lidar frame
  Eigen::MatrixXf descriptors;          // one column each, unit length
};

std::vector<CameraKeypoints> by_camera(const CameraLidarScan& scan, const SiftReturns& keypoints) {
  std::vector<CameraKeypoints> cameras(scan.images.size());
  for (size_t camera = 0; camera < cameras.size(); ++camera) {
    std::vector<Eigen::Index> columns;
    for (size_t k = 0; k < keypoints.size(); ++k) {
      if (keypoints.camera[k] != camera) continue;
      const uint32_t i = keypoints.returns[k];
      const auto& [x, y, z] = scan.sweep.points;
      cameras[camera].points.push_back(Eigen::Vector3f(x[i], y[i], z[i]).cast<double>());
      columns.push_back(static_cast<Eigen::Index>(k));
    }
    cameras[camera].descriptors = keypoints.descriptors(Eigen::all, columns);
  }
  return cameras;
}

struct Match {
  size_t target, source;   // index of the keypoint of its camera
  double square_distance;  // of the descriptors
};

/// The nearest target descriptor of each source descriptor, and the product with the second one.
std::vector<Match> match(const CameraKeypoints& target, const CameraKeypoints& source,
                         double max_ratio) {
  std::vector<Match> matches;
  if (target.points.size() < 2 || source.points.empty()) return matches;
  // Of unit vectors: |a − b|² = 2 − 2 a · b.
  const Eigen::MatrixXf products = target.descriptors.transpose() * source.descriptors;
  for (Eigen::Index s = 0; s < products.cols(); ++s) {
    Eigen::Index best = 0;
    const double first = std::max(0.0, 2 - 2.0 * products.col(s).maxCoeff(&best));
    double second = 4;
    for (Eigen::Index t = 0; t < products.rows(); ++t) {
      if (t != best) second = std::min(second, 2 - 2.0 * products(t, s));
    }
    if (first > max_ratio * max_ratio * second) continue;
    Eigen::Index back = 0;
    products.row(best).maxCoeff(&back);
    if (back == s) matches.push_back({static_cast<size_t>(best), static_cast<size_t>(s), first});
  }
  return matches;
}

/// The matches between the cameras that see the same; `matches`: of each pair of cameras, by row.
Correspondences corresponding_points(const std::vector<CameraKeypoints>& there,
                                     const std::vector<CameraKeypoints>& here,
                                     const std::vector<std::vector<Match>>& matches,
                                     const ConsensusMatrix& consensus) {
  const Eigen::Index cameras = consensus.rows();
  Correspondences pairs;
  for (Eigen::Index i = 0; i < cameras; ++i) {
    for (Eigen::Index j = 0; j < cameras; ++j) {
      if (consensus(i, j) == 0) continue;
      for (const Match& m : matches[static_cast<size_t>(i * cameras + j)]) {
        pairs.target.push_back(there[static_cast<size_t>(i)].points[m.target]);
        pairs.source.push_back(here[static_cast<size_t>(j)].points[m.source]);
      }
    }
  }
  return pairs;
}

}  // namespace

std::optional<std::string> VisualAlignmentOptions::invalid() const {
  if (!(keypoint_radius > 0 && keypoint_radius <= 8))
    return "keypoint_radius must be between 0 and 8";
  if (!(max_ratio > 0 && max_ratio <= 1)) return "max_ratio must be between 0 and 1";
  if (!(min_agreement >= 0 && min_agreement < 1)) return "min_agreement must be between 0 and 1";
  return consensus.invalid();
}

Result<VisualAlignment> align_by_keypoints(const CameraLidarScan& target,
                                           const CameraLidarScan& source,
                                           const VisualAlignmentOptions& options) {
  if (target.images.size() != source.images.size()) {
    return fail("the scans have different numbers of images");
  }
  const auto found_there = find_sift_returns(target, options.keypoint_radius);
  if (!found_there) return tl::unexpected(found_there.error());
  const auto found_here = find_sift_returns(source, options.keypoint_radius);
  if (!found_here) return tl::unexpected(found_here.error());
  const auto there = by_camera(target, *found_there), here = by_camera(source, *found_here);

  constexpr double kMinDistance = 1e-3;  // of identical descriptors, whose inverse has no bound
  const auto cameras = static_cast<Eigen::Index>(target.images.size());
  VisualAlignment out;
  out.measured = ConsensusMatrix::Zero(cameras, cameras);
  std::vector<std::vector<Match>> matches;
  for (Eigen::Index i = 0; i < cameras; ++i) {
    for (Eigen::Index j = 0; j < cameras; ++j) {
      matches.push_back(
          match(there[static_cast<size_t>(i)], here[static_cast<size_t>(j)], options.max_ratio));
      for (const Match& m : matches.back()) {
        out.measured(i, j) += 1 / std::max(m.square_distance, kMinDistance);  // P(4.1)
      }
    }
  }
  out.measured = normalise_rows(out.measured);
  std::vector<CameraMount> mounts;
  for (const ScanImage& image : target.images) mounts.push_back(image.camera);
  const std::vector<ConsensusMatrix> ideal = ideal_consensus(mounts);
  if (!ideal.empty()) out.consensus = ideal[nearest_consensus(out.measured, ideal)];

  const Correspondences pairs = corresponding_points(there, here, matches, out.consensus);
  out.matches = pairs.size();
  out.bootstrap = find_rigid_consensus(pairs, options.consensus);
  if (!out.bootstrap.usable()) {
    out.result.reason = "the images have too little in common";
    return out;
  }
  const PreparedCloud target_cloud = prepare_cloud(target.sweep.points, sweep_options());
  const PreparedCloud source_cloud = prepare_cloud(source.sweep.points, sweep_options());
  out.result =
      refine(target_cloud, source_cloud.cloud, out.bootstrap.hypotheses.front().T_target_source);
  if (!out.result.usable()) return out;
  const ViewOfScan target_view(target_cloud), source_view(source_cloud);
  const ViewAgreement seen = agreement(target_view, target_cloud.cloud, source_view,
                                       source_cloud.cloud, out.result.T_target_source);
  if (seen.share() < options.min_agreement) {
    out.result.reason = "the beams of one sweep pass through what the other measured";
  }
  return out;
}

}  // namespace infuse::registration
