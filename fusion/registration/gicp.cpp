#include "fusion/registration/gicp.hpp"

#include <cmath>

#include "fusion/registration/move_points.hpp"
#include "fusion/registration/uncertainty.hpp"

namespace infuse::registration {
namespace {

using geometry::Vector6;

constexpr double kIdentical = 1e-5;  // m; residuals of clouds that are copies of each other
// A search also bounds the other points' distances, by so much beyond the nearest one's: what the
// points are expected to move in the iterations to come, in units of the last move, at most …
constexpr double kMarginPerMove = 0.6;
constexpr double kMaxMargin = 0.2;  // m

const char* missing(const PreparedCloud& target, const PointCloud& source,
                    const Eigen::Isometry3d& guess, const GicpOptions& options) {
  if (target.search.size() == 0) return "the target has no finite points";
  if (source.size() == 0) return "the source has no finite points";
  if (target.search.size() < options.min_inliers) return "the target has too few points";
  if (source.size() < options.min_inliers) return "the source has too few points";
  if (!guess.matrix().allFinite()) return "the guess is not finite";
  return "";
}

}  // namespace

std::optional<std::string> PrepareOptions::invalid() const {
  if (!(voxel_size >= 0 && voxel_size < 100)) return "voxel_size must be 0 ... 100 m";
  return covariance.invalid();
}

void CloudPreparer::prepare(const geometry::PointsView& points, const PrepareOptions& options,
                            PreparedCloud& out) {
  constexpr double kDistinct = 1e-3;  // m; voxels that keep all points but copies
  downsampler_.compute(points, options.voxel_size > 0 ? options.voxel_size : kDistinct, out.cloud);
  out.search.build_and_sort(out.cloud);
  estimate_covariances(out.search, options.covariance, candidates_, out.cloud);
}

PreparedCloud prepare_cloud(const geometry::PointsView& points, const PrepareOptions& options) {
  PreparedCloud out;
  CloudPreparer().prepare(points, options, out);
  return out;
}

std::optional<std::string> GicpOptions::invalid() const {
  if (!(max_correspondence_distance > 0)) return "max_correspondence_distance must be above 0 m";
  if (!(noise.plane_variance > 0 && noise.plane_variance < 1))
    return "plane_variance must be between 0 and 1";
  if (!(noise.robust_width >= 0)) return "robust_width must not be negative";
  if (max_iterations < 1) return "max_iterations must be at least 1";
  if (!(rotation_tolerance > 0 && translation_tolerance > 0)) return "tolerances must be above 0";
  if (!(min_inlier_fraction >= 0 && min_inlier_fraction <= 1))
    return "min_inlier_fraction must be 0 ... 1";
  if (!(min_plane_fraction >= 0 && min_plane_fraction <= 1))
    return "min_plane_fraction must be 0 ... 1";
  return std::nullopt;
}

Gicp::Gicp(const GicpOptions& options) : options_(options) {}

void Gicp::transform(const PointCloud& source, const Eigen::Isometry3d& T_target_source) {
  move_points(T_target_source, source.points(), pairs_.px, pairs_.py, pairs_.pz);
  Eigen::Isometry3d R = T_target_source;
  R.translation().setZero();
  move_points(R, {source.nx, source.ny, source.nz}, pairs_.sx, pairs_.sy, pairs_.sz);
}

void Gicp::search(const PreparedCloud& target, size_t begin, float margin) {
  const auto max_distance = static_cast<float>(options_.max_correspondence_distance);
  const size_t end = std::min(begin + kLanes, pairs_.size);
  NearestQueries queries{{}, Floats{} - 1};
  bool any = false;
  for (size_t i = begin; i < end; ++i) {
    const float p[3] = {pairs_.px[i], pairs_.py[i], pairs_.pz[i]};
    const float mx = p[0] - searched_x_[i], my = p[1] - searched_y_[i], mz = p[2] - searched_z_[i];
    // Another point can be nearer only after a move of half the difference of the two distances.
    if (mx * mx + my * my + mz * mz < slack_[i] * slack_[i]) continue;
    float reach = max_distance;
    if (index_[i] >= 0) {  // the nearest one is no farther than the former one is now
      const float x = pairs_.qx[i] - p[0], y = pairs_.qy[i] - p[1], z = pairs_.qz[i] - p[2];
      reach = std::min(reach, 1e-4F + std::sqrt(x * x + y * y + z * z));
    }
    const auto lane = static_cast<int>(i - begin);
    for (int axis = 0; axis < 3; ++axis) queries.at[axis][lane] = p[axis];
    queries.max_distance[lane] = reach;
    any = true;
  }
  if (!any) return;
  const NearestOfEach nearest = target.search.nearest_of_each(queries, margin);
  for (size_t i = begin; i < end; ++i) {
    const auto lane = static_cast<int>(i - begin);
    if (queries.max_distance[lane] < 0) continue;
    searched_x_[i] = pairs_.px[i], searched_y_[i] = pairs_.py[i], searched_z_[i] = pairs_.pz[i];
    index_[i] = nearest.index[lane];
    if (index_[i] < 0) {
      slack_[i] = std::max(nearest.others[lane] - max_distance, 0.0F);
    } else {
      slack_[i] = 0.5F * (nearest.others[lane] - std::sqrt(nearest.square_distance[lane]));
      const auto j = static_cast<size_t>(index_[i]);
      pairs_.qx[i] = target.cloud.x[j];
      pairs_.qy[i] = target.cloud.y[j];
      pairs_.qz[i] = target.cloud.z[j];
      pairs_.tx[i] = target.cloud.nx[j];
      pairs_.ty[i] = target.cloud.ny[j];
      pairs_.tz[i] = target.cloud.nz[j];
    }
  }
}

size_t Gicp::find_pairs(const PreparedCloud& target, double last_move) {
  const auto max_distance = static_cast<float>(options_.max_correspondence_distance);
  const auto margin = static_cast<float>(std::min(kMarginPerMove * last_move, kMaxMargin));
  for (size_t begin = 0; begin < pairs_.size; begin += kLanes) search(target, begin, margin);
  size_t found = 0;
  for (size_t i = 0; i < pairs_.size; ++i) {
    const float dx = pairs_.qx[i] - pairs_.px[i], dy = pairs_.qy[i] - pairs_.py[i],
                dz = pairs_.qz[i] - pairs_.pz[i];
    const bool paired =
        index_[i] >= 0 && dx * dx + dy * dy + dz * dz <= max_distance * max_distance;
    pairs_.weight[i] = paired ? 1.0F : 0.0F;
    found += paired ? 1 : 0;
  }
  return found;
}

RegistrationResult Gicp::align(const PreparedCloud& target, const PointCloud& source,
                               const Eigen::Isometry3d& T_target_source_guess) {
  RegistrationResult result;
  result.T_target_source = T_target_source_guess;
  result.points = source.size();
  result.reason = missing(target, source, T_target_source_guess, options_);
  if (*result.reason != '\0') return result;

  pairs_.resize(source.size());
  for (Pairs::Field* field : {&searched_x_, &searched_y_, &searched_z_, &slack_}) {
    field->assign(source.size(), 0.0F);
  }
  index_.assign(source.size(), -1);
  for (Pairs::Field* field :
       {&pairs_.qx, &pairs_.qy, &pairs_.qz, &pairs_.tx, &pairs_.ty, &pairs_.tz}) {
    std::fill(field->begin(), field->end(), 0.0F);
  }
  PoseSystem system;
  DeterminedDirections determined;
  double last_move = 0;  // m, of points at the radius
  while (result.iterations < options_.max_iterations && !result.converged) {
    transform(source, result.T_target_source);
    result.inliers = find_pairs(target, last_move);
    if (result.inliers < options_.min_inliers ||
        static_cast<double>(result.inliers) <
            options_.min_inlier_fraction * static_cast<double>(source.size())) {
      result.reason = "the clouds do not overlap";
      return result;
    }
    system = pose_system(pairs_, options_.noise);
    determined = determined_directions(pairs_, system, options_.noise, options_.min_plane_fraction);
    const Vector6 step = determined_step(system, determined);
    if (!step.allFinite()) {
      result.reason = "the points do not determine a pose";
      return result;
    }
    result.T_target_source = geometry::exp(step) * result.T_target_source;
    last_move = step.tail<3>().norm() + system.radius * step.head<3>().norm();
    result.converged = step.head<3>().norm() <= options_.rotation_tolerance &&
                       step.tail<3>().norm() <= options_.translation_tolerance;
    ++result.iterations;
  }
  set_uncertainty(pairs_, options_.noise, system, determined, cluster_gradients_, result);
  if (!result.converged) {
    result.reason = "the registration did not converge";
  } else if (determined.count == 0) {
    result.reason = "the planes determine no direction";
  } else if (result.rms < kIdentical) {
    result.reason = "the clouds are identical: they do not show the accuracy";
  }
  return result;
}

RegistrationResult gicp(const PreparedCloud& target, const PointCloud& source,
                        const Eigen::Isometry3d& T_target_source_guess,
                        const GicpOptions& options) {
  return Gicp(options).align(target, source, T_target_source_guess);
}

}  // namespace infuse::registration
