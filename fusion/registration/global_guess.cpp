#include "fusion/registration/global_guess.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/registration/refine.hpp"
#include "fusion/registration/view_agreement.hpp"

namespace infuse::registration {
namespace {

/// Keypoints of a scan with their features, scaled so that the Euclidean distance compares
/// histograms (Hellinger).
struct Keypoints {
  std::vector<Eigen::Vector3d> points;
  Eigen::MatrixXf features;  // one column per keypoint
};

Keypoints find_keypoints(const PointCloud& cloud, const GlobalGuessOptions& options) {
  std::vector<Eigen::Vector3f> points(cloud.size());
  for (size_t i = 0; i < cloud.size(); ++i) points[i] = {cloud.x[i], cloud.y[i], cloud.z[i]};
  const features::FpfhCloud shape = features::compute_fpfh(points, options.fpfh);
  // A histogram with all pairs in one bin, as of a plane, fits everywhere: the most even ones say
  // most.
  std::vector<std::pair<float, uint32_t>> order;
  for (size_t i = 0; i < points.size(); ++i) {
    if (shape.has_feature[i] == 0) continue;
    float concentration = 0;
    for (const float share : shape.features[i]) concentration += share * share;
    order.emplace_back(concentration, static_cast<uint32_t>(i));
  }
  std::sort(order.begin(), order.end());
  order.resize(std::min(order.size(), options.max_keypoints));
  Keypoints out;
  out.features.resize(shape.features.empty() ? 0 : 3 * features::kFpfhBins,
                      static_cast<Eigen::Index>(order.size()));
  for (size_t k = 0; k < order.size(); ++k) {
    const uint32_t i = order[k].second;
    out.points.push_back(points[i].cast<double>());
    for (size_t bin = 0; bin < shape.features[i].size(); ++bin) {
      out.features(static_cast<Eigen::Index>(bin), static_cast<Eigen::Index>(k)) =
          std::sqrt(shape.features[i][bin]);
    }
  }
  return out;
}

/// Index of the nearest feature of `among` for each of `features`.
std::vector<Eigen::Index> nearest_features(const Eigen::MatrixXf& features,
                                           const Eigen::MatrixXf& among) {
  // All histograms have the same norm, so the nearest has the largest product.
  std::vector<Eigen::Index> nearest(static_cast<size_t>(features.cols()));
  constexpr Eigen::Index kBlock = 256;  // bounds memory
  for (Eigen::Index begin = 0; begin < features.cols(); begin += kBlock) {
    const Eigen::Index count = std::min(kBlock, features.cols() - begin);
    const Eigen::MatrixXf products = among.transpose() * features.middleCols(begin, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      products.col(k).maxCoeff(&nearest[static_cast<size_t>(begin + k)]);
    }
  }
  return nearest;
}

/// Pairs of keypoints that are each other's nearest feature.
Correspondences match(const Keypoints& target, const Keypoints& source) {
  Correspondences out;
  if (target.points.empty() || source.points.empty()) return out;
  const auto in_target = nearest_features(source.features, target.features);
  const auto in_source = nearest_features(target.features, source.features);
  for (size_t k = 0; k < source.points.size(); ++k) {
    const auto m = static_cast<size_t>(in_target[k]);
    if (in_source[m] != static_cast<Eigen::Index>(k)) continue;
    out.target.push_back(target.points[m]);
    out.source.push_back(source.points[k]);
  }
  return out;
}

RegistrationResult refuse(const char* reason) {
  RegistrationResult out;
  out.reason = reason;
  return out;
}

bool distinct(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
              const RigidConsensusOptions& options) {
  return (a.translation() - b.translation()).norm() >= options.distinct_translation ||
         (a.linear().transpose() * b.linear()).trace() <=
             1 + 2 * std::cos(options.distinct_rotation);
}

}  // namespace

std::optional<std::string> GlobalGuessOptions::invalid() const {
  if (!(voxel_size > 0 && voxel_size < 100)) return "voxel_size must be between 0 and 100 m";
  if (!(min_overlap >= 0 && min_overlap < 1)) return "min_overlap must be between 0 and 1";
  if (max_keypoints < 10 || max_keypoints > 20'000)
    return "max_keypoints must be between 10 and 20000";
  if (!(min_agreement > 0 && min_agreement < 1)) return "min_agreement must be between 0 and 1";
  if (!(min_lead >= 0 && min_lead < 1)) return "min_lead must be between 0 and 1";
  if (auto wrong = fpfh.invalid()) return wrong;
  return consensus.invalid();
}

RegistrationResult find_global_guess(const geometry::PointsView& target,
                                     const geometry::PointsView& source,
                                     const GlobalGuessOptions& options) {
  const PrepareOptions prepare = sweep_options(options.voxel_size);
  const PreparedCloud there = prepare_cloud(target, prepare);
  const PreparedCloud here = prepare_cloud(source, prepare);
  const size_t least = options.consensus.min_inliers;
  if (there.search.size() < least) return refuse("the target has too few points");
  if (here.search.size() < least) return refuse("the source has too few points");
  const Correspondences pairs =
      match(find_keypoints(there.cloud, options), find_keypoints(here.cloud, options));
  const RigidConsensus consensus = find_rigid_consensus(pairs, options.consensus);
  if (!consensus.usable()) return refuse("no pose agrees with the shapes of both scans");

  const ViewOfScan target_view(there), source_view(here);
  struct Scored {
    RegistrationResult result;
    ViewAgreement agreement;
  };
  std::vector<Scored> scored;
  const char* reason = nullptr;  // why the first of the poses that are not usable is not
  for (const RigidHypothesis& hypothesis : consensus.hypotheses) {
    const RegistrationResult result = refine(there, here.cloud, hypothesis.T_target_source);
    if (!result.usable()) {
      if (reason == nullptr) reason = result.reason;
      continue;
    }
    scored.push_back({result, agreement(target_view, there.cloud, source_view, here.cloud,
                                        result.T_target_source)});
  }
  if (scored.empty()) return refuse(reason);
  std::stable_sort(scored.begin(), scored.end(), [](const Scored& a, const Scored& b) {
    return a.agreement.score() > b.agreement.score();
  });
  const Scored& best = scored.front();
  if (best.agreement.overlap() < options.min_overlap) {
    return refuse("the scans have too little in common");
  }
  if (best.agreement.share() < options.min_agreement) {
    return refuse("the beams of one sweep pass through what the other measured");
  }
  for (const Scored& other : scored) {
    if (distinct(best.result.T_target_source, other.result.T_target_source, options.consensus) &&
        other.agreement.score() > (1 - options.min_lead) * best.agreement.score()) {
      return refuse("another pose agrees as well");
    }
  }
  return best.result;
}

}  // namespace infuse::registration
