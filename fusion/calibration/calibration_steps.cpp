#include "fusion/calibration/calibration_steps.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "fusion/calibration/named_measures.hpp"
#include "fusion/calibration/pose_score.hpp"
#include "fusion/calibration/rejection_reason.hpp"
#include "fusion/calibration/scene_similarity.hpp"
#include "fusion/calibration/thin_scenes.hpp"
#include "fusion/geometry/draw_uniform.hpp"

namespace infuse::calibration {
namespace {

using geometry::Vector6;

constexpr double kMaxSameMaximumRotation = 0.3 * kDegree;
constexpr double kMaxSameMaximumTranslation = 0.04;
constexpr double kArrivedShare = 1.0 / 3;  // of both: a restart so near has converged (decision 7)
// Half width of the screening (rad) beyond which the score with other scenes' images is subtracted,
// see `PoseScore`.
constexpr double kMinBaselineHalfWidth = 0.1;
constexpr double kFineRestartTolerance = 5e-3;  // derived from CalibrateOptions::fine: its first
constexpr int kDrawsPerRestart = 40;            // poses drawn for one ascent (decision 4)
constexpr double kManyScenes = 15;    // effective ones: then fewer restarts suffice (decision 5)
constexpr int kMaxRestartRounds = 4;  // bounds time: rounds that each found a larger value
constexpr int kRestartBatches = 2;    // the second where not all of the first converged
// A displacement along the driving direction looks like images of another time.
constexpr double kMinDelaySpeed = 1;     // m/s, mean of the scenes
constexpr double kMinDelayCosine = 0.9;  // of the angle between displacement and driving

/// True if two poses are closer to each other than `share` of what different maxima are.
bool is_within(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double share) {
  const Vector6 apart = geometry::log(a * b.inverse());
  return apart.head<3>().norm() <= share * kMaxSameMaximumRotation &&
         apart.tail<3>().norm() <= share * kMaxSameMaximumTranslation;
}

struct Scored {
  Eigen::Isometry3d T;
  double score;
};

void sort_by_score(std::vector<Scored>& poses) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const Scored& a, const Scored& b) { return a.score > b.score; });
}

/// Returns the different maxima with the largest scores, best first.
std::vector<Eigen::Isometry3d> best_maxima(std::vector<Scored>& ends, size_t max_maxima) {
  sort_by_score(ends);
  std::vector<Eigen::Isometry3d> best;
  for (const Scored& end : ends) {
    if (best.size() == max_maxima) break;
    const bool known = std::any_of(best.begin(), best.end(), [&](const Eigen::Isometry3d& other) {
      return is_same_maximum(end.T, other);
    });
    if (!known) best.push_back(end.T);
  }
  return best;
}

/// Search terms: those given; else, for the default measure, its own; else `terms`.
std::vector<TermOptions> search_terms_of(const CalibrateOptions& options) {
  if (!options.search_terms.empty()) return options.search_terms;
  return options.terms.empty() ? named_measures().front().search_terms : options.terms;
}

std::vector<TermOptions> concatenate(std::vector<TermOptions> terms,
                                     const std::vector<TermOptions>& others) {
  terms.insert(terms.end(), others.begin(), others.end());
  return terms;
}

}  // namespace

bool is_same_maximum(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return is_within(a, b, 1);
}

CalibrationSteps::CalibrationSteps(std::span<const Scene> scenes,
                                   std::span<const RigCamera> cameras,
                                   const Eigen::Isometry3d& initial_pose,
                                   const CalibrateOptions& options)
    : cameras_(cameras),
      initial_pose_(initial_pose),
      options_(options),
      similarity_(scene_similarity(scenes)),
      weights_(scene_weights(similarity_)),
      terms_(options.terms.empty() ? named_measures().front().terms : options.terms),
      search_terms_(search_terms_of(options)),
      images_(scenes, cameras, concatenate(terms_, search_terms_), image_blurs(options)),
      margin_(options.screen.half_width * std::sqrt(3.0)),
      screening_scenes_(thin(scenes, options.screen_points)),
      coarse_scenes_(thin(scenes, options.coarse_points)),
      fine_scenes_(thin(scenes, options.fine_points, true)),
      final_search_(fine_scenes_, cameras, terms_, images_, options.visibility, options.maximize,
                    prior_position(), options.initial_translation_sigma),
      fine_search_(fine_scenes_, cameras, search_terms_, images_, options.visibility,
                   options.maximize, prior_position(), options.initial_translation_sigma),
      coarse_search_(coarse_scenes_, cameras, search_terms_, images_, options.visibility,
                     options.maximize, prior_position(), options.initial_translation_sigma) {}

std::vector<Scene> CalibrationSteps::thin(std::span<const Scene> scenes, size_t points,
                                          bool keep_edges) const {
  return thin_scenes(scenes, cameras_, initial_pose_, margin_, points, keep_edges, weights_);
}

Eigen::Isometry3d CalibrationSteps::find_basin(double prior_scale) {
  VisibilityOptions open = options_.visibility;
  open.occlusion.reset();
  PoseScore screening_score(
      screening_scenes_, cameras_, search_terms_, open, images_, options_.screen_sigma,
      options_.screen.half_width > kMinBaselineHalfWidth, options_.maximize.stop);
  std::vector<Eigen::Isometry3d> poses =
      screen_rotations(initial_pose_, options_.screen, std::ref(screening_score));
  evaluations_ += screening_score.evaluations();
  for (Level level : options_.coarse) {
    level.prior_weight *= prior_scale;
    poses = ascend_from_all(poses, level);
  }
  return poses.front();
}

CalibrationSteps::RestartResult CalibrationSteps::run_restarts(const Eigen::Isometry3d& T) {
  if (options_.restarts == 0) return {.T = T};
  std::mt19937_64 random(options_.seed);
  PoseScore score(coarse_scenes_, cameras_, search_terms_, options_.visibility, images_,
                  options_.coarse.back().sigma, false, options_.maximize.stop);
  const Draw draw{
      .restarts = effective_scenes() < kManyScenes ? options_.restarts_of_few : options_.restarts,
      .rotation = options_.restart_rotation,
      .translation = options_.restart_translation,
      .sigma = restart_levels().front().sigma};
  RestartResult restart_result{.T = T};
  for (int round = 0; round < kMaxRestartRounds; ++round) {
    const double best = score(restart_result.T);
    restart_result.restarts = restart_result.converged_restarts = 0;
    restart_result.best_of_restarts = false;
    std::optional<Eigen::Isometry3d> better;
    for (int batch = 0; batch < kRestartBatches && !better; ++batch) {
      if (batch > 0 && restart_result.converged_restarts == restart_result.restarts) break;
      for (const Eigen::Isometry3d& drawn : draw_around(restart_result.T, draw, random)) {
        const Eigen::Isometry3d end = restart_from(drawn, restart_result.T);
        ++restart_result.restarts;
        if (is_same_maximum(end, restart_result.T)) {
          ++restart_result.converged_restarts;
        } else if (score(end) > best) {
          better = end;
          break;
        }
      }
    }
    if (!better) {
      restart_result.best_of_restarts = true;
      break;
    }
    restart_result.T = *better;
  }
  evaluations_ += score.evaluations();
  return restart_result;
}

std::optional<Eigen::Isometry3d> CalibrationSteps::run_fine_restarts(const Eigen::Isometry3d& T) {
  if (options_.fine_restarts == 0) return std::nullopt;
  std::mt19937_64 random(options_.seed);
  const Draw draw{.restarts = options_.fine_restarts,
                  .rotation = options_.fine_restart_rotation,
                  .translation = options_.fine_restart_translation,
                  .sigma = options_.fine.back().sigma};
  const Level level{.sigma = draw.sigma, .tolerance = kFineRestartTolerance};
  const VisiblePoints points = select_visible(coarse_scenes_, cameras_, T, options_.visibility);
  Objective measure(points, images_.at(ImageBlur::in_angle(level.sigma)), cameras_, coarse_scenes_,
                    search_terms_);
  const auto ascend = [&](const Eigen::Isometry3d& from) {
    const Eigen::Isometry3d end = coarse_search_.ascend(from, std::span(&level, 1)).T_refcam_lidar;
    return Scored{end, measure.evaluate(end, false).estimate.value};
  };
  const Scored given = ascend(T);
  Scored best = given;
  for (const Eigen::Isometry3d& drawn : draw_around(T, draw, random)) {
    const Scored end = ascend(drawn);
    if (end.score > best.score) best = end;
  }
  evaluations_ += measure.evaluations();
  if (is_within(best.T, given.T, kArrivedShare)) return std::nullopt;
  return best.T;
}

Eigen::Isometry3d CalibrationSteps::restart_from(const Eigen::Isometry3d& drawn,
                                                 const Eigen::Isometry3d& result) {
  Eigen::Isometry3d T = drawn;
  for (const Level& level : restart_levels()) {
    T = coarse_search_.ascend(T, std::span(&level, 1)).T_refcam_lidar;
    if (is_within(T, result, kArrivedShare)) break;
  }
  return T;
}

std::optional<geometry::Matrix6> CalibrationSteps::split_half(const Eigen::Isometry3d& T) {
  if (options_.splits == 0 || coarse_scenes_.size() < 2) return std::nullopt;
  std::mt19937_64 random(options_.seed);
  geometry::Matrix6 sum = geometry::Matrix6::Zero();
  for (int split = 0; split < options_.splits; ++split) {
    std::vector<size_t> order(coarse_scenes_.size());
    std::iota(order.begin(), order.end(), size_t{0});
    for (size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[random() % k]);
    const std::span<const size_t> all(order);
    const Eigen::Isometry3d one = ascend_with_scenes(T, all.first(all.size() / 2));
    const Eigen::Isometry3d other = ascend_with_scenes(T, all.subspan(all.size() / 2));
    const Vector6 apart = geometry::log(one * other.inverse());
    sum += apart * apart.transpose();
  }
  return 0.25 / options_.splits * sum;
}

std::vector<std::optional<IntrinsicsEstimate>> CalibrationSteps::estimate_all_intrinsics(
    const Eigen::Isometry3d& T, const Uncertainty& uncertainty) {
  std::vector<std::optional<IntrinsicsEstimate>> all;
  for (size_t c = 0; options_.check_intrinsics && c < cameras_.size(); ++c) {
    all.push_back(estimate_intrinsics(fine_scenes_, cameras_, c, search_terms_, terms_, images_,
                                      options_.visibility, T, uncertainty, options_.maximize.stop));
  }
  return all;
}

std::vector<ParameterCheck> CalibrationSteps::check_parameters(
    const Eigen::Isometry3d& T, const Uncertainty& uncertainty,
    std::span<const std::optional<IntrinsicsEstimate>> estimates) const {
  std::vector<ParameterCheck> all =
      check_model(T, cameras_.size(), fine_scenes_, uncertainty, options_.known);
  for (size_t c = 0; c < estimates.size(); ++c) {
    set_limits(estimates[c], c, all);
  }
  for (size_t c = 0; c < estimates.size(); ++c) {
    auto gross = estimates[c] ? detect_gross_error(*estimates[c], cameras_, c, options_.known)
                              : std::nullopt;
    if (!gross) continue;
    const auto same = std::find_if(all.begin(), all.end(), [&](const ParameterCheck& check) {
      return check.parameter == gross->parameter;
    });
    if (same != all.end()) {
      gross->detection_limit = same->detection_limit;
      all.erase(same);
    }
    all.insert(all.begin(), *std::move(gross));
  }
  return all;
}

std::optional<double> CalibrationSteps::delay_along_travel(const Eigen::Isometry3d& T) const {
  const Eigen::Vector3d moved = T.inverse().translation() - prior_position();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  for (const Scene& scene : fine_scenes_) {
    if (!scene.twist) return std::nullopt;
    velocity += scene.twist->tail<3>() / static_cast<double>(fine_scenes_.size());
  }
  const double along = moved.dot(velocity);
  if (moved.norm() <= kMaxTranslationSigmas * options_.initial_translation_sigma ||
      velocity.norm() < kMinDelaySpeed ||
      std::abs(along) < kMinDelayCosine * moved.norm() * velocity.norm()) {
    return std::nullopt;
  }
  return along / velocity.squaredNorm();
}

double CalibrationSteps::effective_scenes() const {
  return calibration::effective_scenes(similarity_, weights_);
}

int CalibrationSteps::evaluations() const {
  return evaluations_ + final_search_.evaluations() + fine_search_.evaluations() +
         coarse_search_.evaluations();
}

void CalibrationSteps::set_limits(const std::optional<IntrinsicsEstimate>& estimate, size_t camera,
                                  std::vector<ParameterCheck>& all) const {
  const double focal_length = cameras_[camera].model.intrinsics().fx;
  const auto in_unit = [&](size_t i, const Eigen::Vector4d& values) {
    return make_intrinsic_check(i, values(static_cast<Eigen::Index>(i)), camera, cameras_.size())
        .value;
  };
  Eigen::Vector4d unseen = Eigen::Vector4d::Zero();
  if (!options_.known.intrinsics_stated) {
    unseen = unmeasured_errors(estimate, focal_length, options_.known);
  } else if (estimate) {
    unseen = unseen_errors(*estimate, focal_length, options_.known);
  }
  for (size_t i = 0; i < 4 && 4 * camera + i < all.size(); ++i) {
    ParameterCheck& check = all[4 * camera + i];
    check.unseen_sigma = in_unit(i, unseen);
    if (estimate) {
      check.detection_limit = in_unit(i, detection_limits(*estimate, options_.known));
    }
  }
}

std::span<const Level> CalibrationSteps::restart_levels() const {
  const std::span<const Level> levels(options_.coarse);
  return levels.last(std::min<size_t>(2, levels.size()));
}

std::vector<Eigen::Isometry3d> CalibrationSteps::draw_around(const Eigen::Isometry3d& T,
                                                             const Draw& draw,
                                                             std::mt19937_64& random) {
  const VisiblePoints points = select_visible(screening_scenes_, cameras_, T, options_.visibility);
  Objective measure(points, images_.at(ImageBlur::in_angle(draw.sigma)), cameras_,
                    screening_scenes_, search_terms_);
  std::vector<Scored> drawn;
  for (int k = 0; k < kDrawsPerRestart * draw.restarts; ++k) {
    if (options_.maximize.stop.stop_requested()) return {};
    Vector6 xi;
    for (int axis = 0; axis < 6; ++axis) {
      xi(axis) = geometry::draw_uniform(random) * (axis < 3 ? draw.rotation : draw.translation);
    }
    const Eigen::Isometry3d pose = geometry::exp(xi) * T;
    drawn.push_back({pose, measure.evaluate(pose, false).estimate.value});
  }
  evaluations_ += measure.evaluations();
  sort_by_score(drawn);
  std::vector<Eigen::Isometry3d> best;
  for (int k = 0; k < draw.restarts; ++k) best.push_back(drawn[static_cast<size_t>(k)].T);
  return best;
}

Eigen::Isometry3d CalibrationSteps::ascend_with_scenes(const Eigen::Isometry3d& T,
                                                       std::span<const size_t> scenes) {
  std::vector<Scene> part(coarse_scenes_.size());
  for (size_t s = 0; s < coarse_scenes_.size(); ++s) part[s].camera = coarse_scenes_[s].camera;
  for (const size_t s : scenes) part[s] = coarse_scenes_[s];
  CoarseToFine search(part, cameras_, search_terms_, images_, options_.visibility,
                      options_.maximize, prior_position(), options_.initial_translation_sigma);
  Eigen::Isometry3d end = search.ascend(T, restart_levels().last(1)).T_refcam_lidar;
  evaluations_ += search.evaluations();
  return end;
}

std::vector<Eigen::Isometry3d> CalibrationSteps::ascend_from_all(
    const std::vector<Eigen::Isometry3d>& from, const Level& level) {
  PoseScore score(coarse_scenes_, cameras_, search_terms_, options_.visibility, images_,
                  level.sigma, false, options_.maximize.stop);
  std::vector<Scored> ends;
  for (const Eigen::Isometry3d& T : from) {
    const Eigen::Isometry3d end = coarse_search_.ascend(T, std::span(&level, 1)).T_refcam_lidar;
    ends.push_back({end, score(end)});
  }
  evaluations_ += score.evaluations();
  return best_maxima(ends, static_cast<size_t>(level.survivors));
}

}  // namespace infuse::calibration
