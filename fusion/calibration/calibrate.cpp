#include "fusion/calibration/calibrate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>

#include "fusion/calibration/estimate_intrinsics.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "fusion/calibration/pose_score.hpp"
#include "fusion/calibration/thin_scenes.hpp"

namespace infuse::calibration {
namespace {

using geometry::Vector6;

constexpr double kMaxSameMaximumRotation = 0.3 * M_PI / 180;
constexpr double kMaxSameMaximumTranslation = 0.04;
constexpr double kMinBaselineHalfWidth =
    0.1;                                // rad: turned further, pictures of other places fit as well
constexpr int kDrawsPerRestart = 40;    // poses drawn for one that climbs
constexpr int kMaxRestartRounds = 4;    // of restarts that each found a better place
constexpr double kPriorScale = 1;       // times the anchors of the levels
constexpr double kRetryPriorScale = 3;  // the same, where the first attempt came to nothing
constexpr int kMaxRestartsPerReturn = 4;  // one restart in so many must lead back
constexpr double kMaxTranslationSigmas =
    3;  // standard deviations of the start's translation; 97 % lie nearer

/// Even in [−1, 1]; the standard's distributions differ between libraries.
double draw_uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0;
}

bool is_same_maximum(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Vector6 apart = geometry::log(a * b.inverse());
  return apart.head<3>().norm() <= kMaxSameMaximumRotation &&
         apart.tail<3>().norm() <= kMaxSameMaximumTranslation;
}

std::vector<double> all_sigmas(const CalibrateOptions& options) {
  std::vector<double> sigmas{options.screen_sigma, options.support_sigma};
  for (const auto* levels : {&options.coarse, &options.fine}) {
    for (const Level& level : *levels) sigmas.push_back(level.sigma);
  }
  return sigmas;
}

struct Scored {
  Eigen::Isometry3d T;
  double score;
};

/// The best `most`, best first.
std::vector<Eigen::Isometry3d> best_poses(std::vector<Scored>& poses, size_t max_poses) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const Scored& a, const Scored& b) { return a.score > b.score; });
  std::vector<Eigen::Isometry3d> best;
  for (size_t k = 0; k < std::min(max_poses, poses.size()); ++k) best.push_back(poses[k].T);
  return best;
}

/// Those of the default measure, of the terms that are given, or what is given.
std::vector<TermOptions> search_terms_of(const CalibrateOptions& options) {
  if (!options.search_terms.empty()) return options.search_terms;
  return options.terms.empty() ? named_measures().front().search_terms : options.terms;
}

std::vector<TermOptions> concatenate(std::vector<TermOptions> terms,
                                     const std::vector<TermOptions>& others) {
  terms.insert(terms.end(), others.begin(), others.end());
  return terms;
}

/// All that a calibration's steps share.
class Calibration {
 public:
  Calibration(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
              const Eigen::Isometry3d& start, const CalibrateOptions& options)
      : cameras_(cameras),
        initial_pose_(start),
        options_(options),
        terms_(options.terms.empty() ? named_measures().front().terms : options.terms),
        search_terms_(search_terms_of(options)),
        images_(scenes, concatenate(terms_, search_terms_), all_sigmas(options)),
        margin_(options.screen.half_width * std::sqrt(3.0)),
        screening_scenes_(thin_scenes(scenes, cameras, start, margin_, options.screen_points)),
        coarse_scenes_(thin_scenes(scenes, cameras, start, margin_, options.coarse_points)),
        fine_scenes_(thin_scenes(scenes, cameras, start, margin_, options.fine_points, true)),
        final_search_(fine_scenes_, cameras, terms_, images_, options.visibility, options.maximize,
                      prior_position(), options.initial_translation_sigma),
        fine_search_(fine_scenes_, cameras, search_terms_, images_, options.visibility,
                     options.maximize, prior_position(), options.initial_translation_sigma),
        coarse_search_(coarse_scenes_, cameras, search_terms_, images_, options.visibility,
                       options.maximize, prior_position(), options.initial_translation_sigma) {}

  CoarseToFine& final_search() { return final_search_; }
  CoarseToFine& fine_search() { return fine_search_; }

  /// Where climbs came to rest, and how many of the last round led back there.
  struct RestartResult {
    Eigen::Isometry3d T;
    int returned = 0;
    bool best_of_restarts = true;  // the last round found nothing better
  };

  /// The end of the coarse climbs that scores best; `held` multiplies the levels' anchors.
  Eigen::Isometry3d find_basin(double held) {
    VisibilityOptions open = options_.visibility;
    open.occlusion.reset();
    PoseScore screening_score(
        screening_scenes_, cameras_, search_terms_, open, images_, options_.screen_sigma,
        options_.screen.half_width > kMinBaselineHalfWidth, options_.maximize.stop);
    std::vector<Eigen::Isometry3d> poses =
        screen_rotations(initial_pose_, options_.screen, std::ref(screening_score));
    evaluations_ += screening_score.evaluations();
    for (Level level : options_.coarse) {
      level.prior_weight *= held;
      poses = ascend_from_all(poses, level);
    }
    return poses.front();
  }

  /// Climbs again from around `T`; where that leads to a better place, from around that. Gives back
  /// where it came to rest, and how many of the last round's climbs led back there.
  RestartResult run_restarts(const Eigen::Isometry3d& T) {
    if (options_.restarts == 0) return {.T = T};
    std::mt19937_64 random(options_.seed);
    PoseScore rejection_reason(coarse_scenes_, cameras_, search_terms_, options_.visibility,
                               images_, options_.coarse.back().sigma, false,
                               options_.maximize.stop);
    RestartResult restart_result{.T = T};
    for (int round = 0; round < kMaxRestartRounds; ++round) {
      const double score = rejection_reason(restart_result.T);
      restart_result.returned = 0;
      restart_result.best_of_restarts = false;
      std::optional<Eigen::Isometry3d> better;
      for (const Eigen::Isometry3d& start : draw_around(restart_result.T, random)) {
        if (better) break;
        const Eigen::Isometry3d end = coarse_search_.ascend(start, restart_levels()).T_refcam_lidar;
        if (is_same_maximum(end, restart_result.T)) {
          ++restart_result.returned;
        } else if (rejection_reason(end) > score) {
          better = end;
        }
      }
      if (!better) {
        restart_result.best_of_restarts = true;
        break;
      }
      restart_result.T = *better;
    }
    evaluations_ += rejection_reason.evaluations();
    return restart_result;
  }

  /// The scenes are halved at random; how far apart do the halves come to rest?
  std::optional<geometry::Matrix6> split_half(const Eigen::Isometry3d& T) {
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

  /// What the scenes say of the cameras and of the clock.
  std::vector<ModelMismatch> find_mismatches(Objective& finest, const Eigen::Isometry3d& T,
                                             const Uncertainty& uncertainty) {
    std::vector<ModelMismatch> all = check_model(finest, T, cameras_, fine_scenes_, uncertainty);
    for (size_t c = 0; options_.check_intrinsics && c < cameras_.size(); ++c) {
      const auto estimate = estimate_intrinsics(fine_scenes_, cameras_, c, search_terms_, images_,
                                                options_.visibility, T, options_.maximize.stop);
      const auto gross = estimate ? detect_gross_mismatch(*estimate, cameras_, c) : std::nullopt;
      if (!gross) continue;
      std::erase_if(
          all, [&](const ModelMismatch& doubt) { return doubt.parameter == gross->parameter; });
      all.insert(all.begin(), *gross);
    }
    return all;
  }

  int evaluations() const {
    return evaluations_ + final_search_.evaluations() + fine_search_.evaluations() +
           coarse_search_.evaluations();
  }

 private:
  /// The two finest of the coarse levels.
  std::span<const Level> restart_levels() const {
    const std::span<const Level> levels(options_.coarse);
    return levels.last(std::min<size_t>(2, levels.size()));
  }

  /// Poses from around `T`: of many that are drawn, those that score best.
  std::vector<Eigen::Isometry3d> draw_around(const Eigen::Isometry3d& T, std::mt19937_64& random) {
    PoseScore screening_score(screening_scenes_, cameras_, search_terms_, options_.visibility,
                              images_, restart_levels().front().sigma, false,
                              options_.maximize.stop);
    std::vector<Scored> drawn;
    for (int k = 0; k < kDrawsPerRestart * options_.restarts; ++k) {
      Vector6 xi;
      for (int axis = 0; axis < 6; ++axis) {
        xi(axis) = draw_uniform(random) *
                   (axis < 3 ? options_.restart_rotation : options_.restart_translation);
      }
      const Eigen::Isometry3d pose = geometry::exp(xi) * T;
      drawn.push_back({pose, screening_score(pose)});
    }
    evaluations_ += screening_score.evaluations();
    return best_poses(drawn, static_cast<size_t>(options_.restarts));
  }

  /// The finest coarse levels with some of the scenes alone.
  Eigen::Isometry3d ascend_with_scenes(const Eigen::Isometry3d& T, std::span<const size_t> scenes) {
    std::vector<Scene> part(coarse_scenes_.size());
    for (size_t s = 0; s < coarse_scenes_.size(); ++s) part[s].camera = coarse_scenes_[s].camera;
    for (const size_t s : scenes) part[s] = coarse_scenes_[s];
    CoarseToFine search(part, cameras_, search_terms_, images_, options_.visibility,
                        options_.maximize, prior_position(), options_.initial_translation_sigma);
    const Eigen::Isometry3d end = search.ascend(T, restart_levels()).T_refcam_lidar;
    evaluations_ += search.evaluations();
    return end;
  }

  /// Climbs one level from each; gives back the best ends, best first.
  std::vector<Eigen::Isometry3d> ascend_from_all(const std::vector<Eigen::Isometry3d>& from,
                                                 const Level& level) {
    PoseScore rejection_reason(coarse_scenes_, cameras_, search_terms_, options_.visibility,
                               images_, level.sigma, false, options_.maximize.stop);
    std::vector<Scored> ends;
    for (const Eigen::Isometry3d& T : from) {
      const Eigen::Isometry3d end = coarse_search_.ascend(T, std::span(&level, 1)).T_refcam_lidar;
      ends.push_back({end, rejection_reason(end)});
    }
    evaluations_ += rejection_reason.evaluations();
    return best_poses(ends, static_cast<size_t>(level.survivors));
  }

  Eigen::Vector3d prior_position() const { return initial_pose_.inverse().translation(); }

  std::span<const RigCamera> cameras_;
  Eigen::Isometry3d initial_pose_;
  const CalibrateOptions& options_;
  std::vector<TermOptions> terms_, search_terms_;
  ImagePyramid images_;
  double margin_;
  std::vector<Scene> screening_scenes_, coarse_scenes_, fine_scenes_;
  CoarseToFine final_search_, fine_search_, coarse_search_;
  int evaluations_ = 0;
};

double mean_support(const std::vector<SceneSupport>& scenes) {
  double sum = 0;
  int seen = 0;
  for (const SceneSupport& scene : scenes) {
    if (scene.points == 0) continue;
    sum += scene.support;
    ++seen;
  }
  return seen == 0 ? 0 : sum / seen;
}

template <class... Values>
std::string format_text(const char* format, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

std::string mismatch_text(const ModelMismatch& doubt) {
  const std::string by = doubt.value == 0 ? ""
                                          : format_text("%+.2g%s%s, ", doubt.value,
                                                        *doubt.unit == '\0' ? "" : " ", doubt.unit);
  return format_text("lidar and pictures would fit better with another %s (%s%.0f sigma)",
                     doubt.parameter.c_str(), by.c_str(), std::abs(doubt.significance));
}

/// Why the result cannot be used, or an empty text.
std::string rejection_reason(const CalibrationResult& result, const Maximum& maximum, double moved,
                             const CalibrateOptions& options) {
  if (!maximum.usable()) return maximum.reason;
  if (!result.uncertainty.usable()) return result.uncertainty.reason;
  for (const ModelMismatch& doubt : result.model_mismatches) {
    if (doubt.gross) return mismatch_text(doubt);  // what follows may come of it
  }
  if (result.support < options.min_support) {
    return format_text(
        "the scenes do not support it: only %.0f %% of small wrong rotations make them fit worse "
        "(%.0f %% expected); do pictures and sweeps belong together?",
        100 * result.support, 100 * options.min_support);
  }
  if (!result.best_of_restarts) {
    return "restarts from around it kept finding better places";
  }
  if (kMaxRestartsPerReturn * result.returned < result.restarts) {
    return format_text("only %d of %d restarts from around it led back", result.returned,
                       result.restarts);
  }
  for (const ModelMismatch& doubt : result.model_mismatches) {
    if (doubt.serious) return mismatch_text(doubt);
  }
  if (moved > kMaxTranslationSigmas * options.initial_translation_sigma) {
    return format_text("it moved %.2f m from the start, whose translation is known to %.2f m",
                       moved, options.initial_translation_sigma);
  }
  return {};
}

/// Finds a calibration with the levels' anchors multiplied by `held`, and judges it.
CalibrationResult run_attempt(Calibration& calibration, const Eigen::Isometry3d& start,
                              size_t scenes, const CalibrateOptions& options, double held) {
  CalibrationResult result;
  CoarseToFine& search = calibration.final_search();
  const Calibration::RestartResult restart_result =
      calibration.run_restarts(calibration.find_basin(held));
  const std::span<const Level> fine(options.fine);
  const Maximum fine_maximum =
      calibration.fine_search().ascend(restart_result.T, fine.first(fine.size() - 1));
  const Maximum maximum = search.ascend(fine_maximum.T_refcam_lidar, fine.last(1));
  if (options.maximize.stop.stop_requested()) {
    result.T_refcam_lidar = start;
    result.reason = maximum.reason;
    return result;
  }
  result.T_refcam_lidar = maximum.T_refcam_lidar;
  result.restarts = options.restarts;
  result.returned = restart_result.returned;
  result.best_of_restarts = restart_result.best_of_restarts;

  const VisiblePoints points = search.visible_points(result.T_refcam_lidar, fine.back().points);
  Objective finest = search.make_objective(points, options.fine.back().sigma);
  result.points = points.size();
  result.value = finest.evaluate(result.T_refcam_lidar, false).estimate.value;
  result.initial_value = finest.evaluate(start, false).estimate.value;
  result.uncertainty = estimate_uncertainty(finest, result.T_refcam_lidar);
  result.model_mismatches =
      calibration.find_mismatches(finest, result.T_refcam_lidar, result.uncertainty);
  result.scenes = scene_support(calibration.fine_search(), result.T_refcam_lidar, scenes,
                                options.support_sigma);
  result.support = mean_support(result.scenes);
  result.evaluations = finest.evaluations();
  const double moved =
      (result.T_refcam_lidar.inverse().translation() - start.inverse().translation()).norm();
  result.reason = rejection_reason(result, maximum, moved, options);
  return result;
}

}  // namespace

std::optional<std::string> CalibrateOptions::invalid() const {
  for (const auto* sum : {&terms, &search_terms}) {
    for (const TermOptions& term : *sum) {
      if (auto wrong = term.invalid()) return "terms: " + *wrong;
    }
  }
  if (coarse.empty() && (screen.survivors > 0 || restarts > 0 || splits > 0)) {
    return "coarse must have at least one level, or nothing can be screened, restarted or split";
  }
  if (fine.empty()) return "fine must have at least one level";
  for (const auto* levels : {&coarse, &fine}) {
    for (const Level& level : *levels) {
      if (auto wrong = level.invalid()) return "level: " + *wrong;
    }
  }
  if (auto wrong = screen.invalid()) return "screen: " + *wrong;
  if (!(screen_sigma >= 0)) return "screen_sigma must not be negative";
  if (screen_points < 100) return "screen_points must be at least 100";
  if (coarse_points < 100) return "coarse_points must be at least 100";
  if (!(initial_translation_sigma > 0)) return "initial_translation_sigma must be positive";
  if (restarts < 0) return "restarts must not be negative";
  if (splits < 0) return "splits must not be negative";
  if (!(restart_rotation >= 0)) return "restart_rotation must not be negative";
  if (!(restart_translation >= 0)) return "restart_translation must not be negative";
  if (!(support_sigma >= 0)) return "support_sigma must not be negative";
  if (!(min_support >= 0 && min_support <= 1)) return "min_support must lie in 0 … 1";
  if (auto wrong = maximize.invalid()) return "maximize: " + *wrong;
  if (auto wrong = visibility.invalid()) return "visibility: " + *wrong;
  return std::nullopt;
}

CalibrationResult calibrate(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                            const Eigen::Isometry3d& T_head_lidar_start,
                            const CalibrateOptions& options) {
  Calibration calibration(scenes, cameras, T_head_lidar_start, options);
  CalibrationResult result =
      run_attempt(calibration, T_head_lidar_start, scenes.size(), options, kPriorScale);
  const bool gross = std::any_of(result.model_mismatches.begin(), result.model_mismatches.end(),
                                 [](const ModelMismatch& doubt) { return doubt.gross; });
  if (!result.usable() && options.restarts > 0 && result.points > 0) {
    const CalibrationResult held =
        run_attempt(calibration, T_head_lidar_start, scenes.size(), options, kRetryPriorScale);
    // At the same place the same camera is as wrong as before.
    const bool there = is_same_maximum(held.T_refcam_lidar, result.T_refcam_lidar);
    if (held.usable() && !(gross && there)) result = held;
  }
  if (result.usable()) result.split_half = calibration.split_half(result.T_refcam_lidar);
  result.evaluations += calibration.evaluations();
  return result;
}

}  // namespace infuse::calibration
