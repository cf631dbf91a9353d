#include "fusion/calibration/calibrate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>

#include "fusion/calibration/named_measures.hpp"
#include "fusion/calibration/pose_score.hpp"
#include "fusion/calibration/scene_similarity.hpp"
#include "fusion/calibration/thin_scenes.hpp"

namespace infuse::calibration {
namespace {

using geometry::Vector6;

constexpr double kMaxSameMaximumRotation = 0.3 * kDegree;
constexpr double kMaxSameMaximumTranslation = 0.04;
// Over wider rotations images of other places fit as well, rad.
constexpr double kMinBaselineHalfWidth = 0.1;
constexpr int kDrawsPerRestart = 40;      // number of poses drawn for one ascent
constexpr int kMaxRestartRounds = 4;      // maximum number of rounds that each found a larger value
constexpr double kPriorScale = 1;         // factor of the levels' prior weights
constexpr double kRetryPriorScale = 3;    // the same where the first attempt is not usable
constexpr int kMaxRestartsPerReturn = 2;  // one restart in so many must converge to the result
constexpr int kRestartBatches = 2;        // the second where not all of the first converged
// Standard deviations of the initial translation; 97 % lie nearer.
constexpr double kMaxTranslationSigmas = 3;
// A displacement along the driving direction looks like images of another time.
constexpr double kMinDelaySpeed = 1;      // m/s, mean of the scenes
constexpr double kMinDelayCosine = 0.9;   // of the angle between displacement and driving
constexpr double kForeignSupport = 0.75;  // images of other places have less

/// Draws evenly from [−1, 1]; the standard's distributions differ between libraries.
double draw_uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0;
}

bool is_same_maximum(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Vector6 apart = geometry::log(a * b.inverse());
  return apart.head<3>().norm() <= kMaxSameMaximumRotation &&
         apart.tail<3>().norm() <= kMaxSameMaximumTranslation;
}

struct Scored {
  Eigen::Isometry3d T;
  double score;
};

/// Returns the poses with the largest scores, best first.
std::vector<Eigen::Isometry3d> best_poses(std::vector<Scored>& poses, size_t max_poses) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const Scored& a, const Scored& b) { return a.score > b.score; });
  std::vector<Eigen::Isometry3d> best;
  for (size_t k = 0; k < std::min(max_poses, poses.size()); ++k) best.push_back(poses[k].T);
  return best;
}

/// Search terms: the given ones, those of the default measure, or the given terms.
std::vector<TermOptions> search_terms_of(const CalibrateOptions& options) {
  if (!options.search_terms.empty()) return options.search_terms;
  return options.terms.empty() ? named_measures().front().search_terms : options.terms;
}

std::vector<TermOptions> concatenate(std::vector<TermOptions> terms,
                                     const std::vector<TermOptions>& others) {
  terms.insert(terms.end(), others.begin(), others.end());
  return terms;
}

/// State that the steps of a calibration share.
class Calibration {
 public:
  Calibration(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
              const Eigen::Isometry3d& initial_pose, const CalibrateOptions& options)
      : cameras_(cameras),
        initial_pose_(initial_pose),
        options_(options),
        similarity_(scene_similarity(scenes)),
        terms_(options.terms.empty() ? named_measures().front().terms : options.terms),
        search_terms_(search_terms_of(options)),
        images_(scenes, concatenate(terms_, search_terms_), image_blurs(options)),
        margin_(options.screen.half_width * std::sqrt(3.0)),
        screening_scenes_(
            thin_scenes(scenes, cameras, initial_pose, margin_, options.screen_points)),
        coarse_scenes_(thin_scenes(scenes, cameras, initial_pose, margin_, options.coarse_points)),
        fine_scenes_(
            thin_scenes(scenes, cameras, initial_pose, margin_, options.fine_points, true)),
        final_search_(fine_scenes_, cameras, terms_, images_, options.visibility, options.maximize,
                      prior_position(), options.initial_translation_sigma),
        fine_search_(fine_scenes_, cameras, search_terms_, images_, options.visibility,
                     options.maximize, prior_position(), options.initial_translation_sigma),
        coarse_search_(coarse_scenes_, cameras, search_terms_, images_, options.visibility,
                       options.maximize, prior_position(), options.initial_translation_sigma) {}

  CoarseToFine& final_search() { return final_search_; }
  CoarseToFine& fine_search() { return fine_search_; }
  const Eigen::MatrixXd& similarity() const { return similarity_; }

  /// Pose after the restarts, and how many of the last round converged to it.
  struct RestartResult {
    Eigen::Isometry3d T;
    int restarts = 0;
    int returned = 0;
    bool best_of_restarts = true;  // the last round found no larger value
  };

  /// Returns the best result of the coarse levels; `prior_scale` multiplies their prior weights.
  Eigen::Isometry3d find_basin(double prior_scale) {
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

  /// Ascends from poses around `T`; repeats this around a better result, where one is found.
  /// Returns the best pose and how many ascents of the last round converged to it.
  RestartResult run_restarts(const Eigen::Isometry3d& T) {
    if (options_.restarts == 0) return {.T = T};
    std::mt19937_64 random(options_.seed);
    PoseScore score(coarse_scenes_, cameras_, search_terms_, options_.visibility, images_,
                    options_.coarse.back().sigma, false, options_.maximize.stop);
    RestartResult restart_result{.T = T};
    for (int round = 0; round < kMaxRestartRounds; ++round) {
      const double best = score(restart_result.T);
      restart_result.restarts = restart_result.returned = 0;
      restart_result.best_of_restarts = false;
      std::optional<Eigen::Isometry3d> better;
      for (int batch = 0; batch < kRestartBatches && !better; ++batch) {
        if (batch > 0 && restart_result.returned == restart_result.restarts) break;
        for (const Eigen::Isometry3d& drawn : draw_around(restart_result.T, random)) {
          const Eigen::Isometry3d end =
              coarse_search_.ascend(drawn, restart_levels()).T_refcam_lidar;
          ++restart_result.restarts;
          if (is_same_maximum(end, restart_result.T)) {
            ++restart_result.returned;
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

  /// Covariance from random halves of the scenes: ¼ mean of the squared difference of their
  /// results.
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

  /// Estimates each camera's intrinsics together with the pose.
  std::vector<std::optional<IntrinsicsEstimate>> estimate_all_intrinsics(
      const Eigen::Isometry3d& T, const Uncertainty& uncertainty) {
    std::vector<std::optional<IntrinsicsEstimate>> all;
    for (size_t c = 0; options_.check_intrinsics && c < cameras_.size(); ++c) {
      all.push_back(estimate_intrinsics(fine_scenes_, cameras_, c, search_terms_, terms_, images_,
                                        options_.visibility, T, uncertainty.effective_scenes,
                                        options_.maximize.stop));
    }
    return all;
  }

  /// Finds errors of the intrinsics and the clock that the scenes indicate.
  std::vector<ModelMismatch> find_mismatches(
      const Eigen::Isometry3d& T, const Uncertainty& uncertainty,
      std::span<const std::optional<IntrinsicsEstimate>> estimates) const {
    std::vector<ModelMismatch> all =
        check_model(T, cameras_.size(), fine_scenes_, uncertainty, options_.known);
    for (size_t c = 0; c < estimates.size(); ++c) {
      if (estimates[c]) add_unseen_errors(*estimates[c], c, all);
    }
    for (size_t c = 0; c < estimates.size(); ++c) {
      const auto gross = estimates[c]
                             ? detect_gross_mismatch(*estimates[c], cameras_, c, options_.known)
                             : std::nullopt;
      if (!gross) continue;
      std::erase_if(all, [&](const ModelMismatch& mismatch) {
        return mismatch.parameter == gross->parameter;
      });
      all.insert(all.begin(), *gross);
    }
    return all;
  }

  /// Delay of the images, s, that displaces the reference camera as far along the driving direction
  /// as it lies from its initial position; nothing if that is near or in another direction.
  std::optional<double> delay_along_travel(const Eigen::Isometry3d& T) const {
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

  int evaluations() const {
    return evaluations_ + final_search_.evaluations() + fine_search_.evaluations() +
           coarse_search_.evaluations();
  }

 private:
  /// Sets the `unseen_sigma` of a camera's intrinsics, in the order of `check_model`.
  void add_unseen_errors(const IntrinsicsEstimate& estimate, size_t camera,
                         std::vector<ModelMismatch>& all) const {
    const Eigen::Vector4d sigmas =
        unseen_errors(estimate, cameras_[camera].model.intrinsics().fx, options_.known);
    for (size_t i = 0; i < 4 && 4 * camera + i < all.size(); ++i) {
      const double sigma = sigmas(static_cast<Eigen::Index>(i));
      all[4 * camera + i].unseen_sigma =
          make_intrinsic_mismatch(i, sigma, camera, cameras_.size()).value;
    }
  }

  /// Returns the two finest of the coarse levels.
  std::span<const Level> restart_levels() const {
    const std::span<const Level> levels(options_.coarse);
    return levels.last(std::min<size_t>(2, levels.size()));
  }

  /// Draws many poses around `T` and returns those that score best.
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

  /// Ascends through the finest coarse levels with some of the scenes alone.
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

  /// Ascends one level from each pose; returns the best results, best first.
  std::vector<Eigen::Isometry3d> ascend_from_all(const std::vector<Eigen::Isometry3d>& from,
                                                 const Level& level) {
    PoseScore score(coarse_scenes_, cameras_, search_terms_, options_.visibility, images_,
                    level.sigma, false, options_.maximize.stop);
    std::vector<Scored> ends;
    for (const Eigen::Isometry3d& T : from) {
      const Eigen::Isometry3d end = coarse_search_.ascend(T, std::span(&level, 1)).T_refcam_lidar;
      ends.push_back({end, score(end)});
    }
    evaluations_ += score.evaluations();
    return best_poses(ends, static_cast<size_t>(level.survivors));
  }

  Eigen::Vector3d prior_position() const { return initial_pose_.inverse().translation(); }

  std::span<const RigCamera> cameras_;
  Eigen::Isometry3d initial_pose_;
  const CalibrateOptions& options_;
  Eigen::MatrixXd similarity_;
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

std::string mismatch_text(const ModelMismatch& mismatch) {
  if (mismatch.gross && mismatch.value == 0) {
    return "a fit of the intrinsics with the pose does not converge near the given ones; check the "
           "intrinsics";
  }
  const std::string by = mismatch.value == 0
                             ? ""
                             : format_text("%+.2g%s%s, ", mismatch.value,
                                           *mismatch.unit == '\0' ? "" : " ", mismatch.unit);
  return format_text("lidar and images would fit better with another %s (%s%.0f sigma)",
                     mismatch.parameter.c_str(), by.c_str(), std::abs(mismatch.significance));
}

/// Returns why the result cannot be used, or an empty text.
std::string rejection_reason(const CalibrationResult& result, const Maximum& maximum, double moved,
                             std::optional<double> delay, const CalibrateOptions& options) {
  if (!maximum.usable()) return maximum.reason;
  if (result.uncertainty.effective_scenes < kMinEffectiveScenes) return result.uncertainty.reason;
  const bool gross = std::any_of(result.model_mismatches.begin(), result.model_mismatches.end(),
                                 [](const ModelMismatch& mismatch) { return mismatch.gross; });
  if (delay && !gross && result.support >= kForeignSupport) {
    return format_text(
        "the result lies %.2f m from the initial position along the driving direction, as with "
        "another image time (%+.0f ms); check the stamps of the images",
        moved, 1e3 * *delay);
  }
  if (result.support < options.min_support && !gross) {
    return format_text(
        "the scenes do not support it: only %.0f %% of small wrong rotations make them fit worse "
        "(%.0f %% expected); check that images and sweeps belong together",
        100 * result.support, 100 * options.min_support);
  }
  for (const ModelMismatch& mismatch : result.model_mismatches) {
    if (mismatch.gross || mismatch.serious) return mismatch_text(mismatch);
  }
  if (!result.best_of_restarts) {
    return "restarts from around the result kept finding larger values";
  }
  if (kMaxRestartsPerReturn * result.returned < result.restarts) {
    return format_text("only %d of %d restarts converged to the result", result.returned,
                       result.restarts);
  }
  if (!result.uncertainty.usable()) return result.uncertainty.reason;
  if (auto imprecise = describe_imprecision(result.covariance(), options.max_rotation_sigma,
                                            options.max_translation_sigma);
      !imprecise.empty()) {
    return imprecise;
  }
  if (moved > kMaxTranslationSigmas * options.initial_translation_sigma) {
    return format_text(
        "the result lies %.2f m from the initial position, whose standard deviation is %.2f m",
        moved, options.initial_translation_sigma);
  }
  return {};
}

/// Calibrates with the levels' prior weights multiplied by `prior_scale`, and checks the result.
CalibrationResult run_attempt(Calibration& calibration, const Eigen::Isometry3d& initial_pose,
                              size_t scenes, const CalibrateOptions& options, double prior_scale) {
  CalibrationResult result;
  CoarseToFine& search = calibration.final_search();
  const Calibration::RestartResult restart_result =
      calibration.run_restarts(calibration.find_basin(prior_scale));
  const std::span<const Level> fine(options.fine);
  const Maximum fine_maximum =
      calibration.fine_search().ascend(restart_result.T, fine.first(fine.size() - 1));
  const Maximum maximum = search.ascend(fine_maximum.T_refcam_lidar, fine.last(1));
  if (options.maximize.stop.stop_requested()) {
    result.T_refcam_lidar = initial_pose;
    result.reason = maximum.reason;
    return result;
  }
  result.T_refcam_lidar = maximum.T_refcam_lidar;
  result.has_pose = maximum.usable();
  result.restarts = restart_result.restarts;
  result.returned = restart_result.returned;
  result.best_of_restarts = restart_result.best_of_restarts;

  const VisiblePoints points = search.visible_points(result.T_refcam_lidar, fine.back().points);
  Objective finest = search.make_objective(points, options.fine.back().sigma);
  result.points = points.size();
  result.value = finest.evaluate(result.T_refcam_lidar, false).estimate.value;
  result.initial_value = finest.evaluate(initial_pose, false).estimate.value;
  result.uncertainty =
      estimate_uncertainty(finest, result.T_refcam_lidar, calibration.similarity());
  result.intrinsics =
      calibration.estimate_all_intrinsics(result.T_refcam_lidar, result.uncertainty);
  result.model_mismatches =
      calibration.find_mismatches(result.T_refcam_lidar, result.uncertainty, result.intrinsics);
  result.model_covariance =
      model_covariance(result.model_mismatches, result.uncertainty.covariance);
  result.scenes = scene_support(calibration.fine_search(), result.T_refcam_lidar, scenes,
                                options.support_sigma);
  result.support = mean_support(result.scenes);
  result.evaluations = finest.evaluations();
  const double moved =
      (result.T_refcam_lidar.inverse().translation() - initial_pose.inverse().translation()).norm();
  result.reason = rejection_reason(result, maximum, moved,
                                   calibration.delay_along_travel(result.T_refcam_lidar), options);
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
  if (!(max_rotation_sigma > 0)) return "max_rotation_sigma must be positive";
  if (!(max_translation_sigma > 0)) return "max_translation_sigma must be positive";
  if (auto wrong = known.invalid()) return "known: " + *wrong;
  if (auto wrong = maximize.invalid()) return "maximize: " + *wrong;
  if (auto wrong = visibility.invalid()) return "visibility: " + *wrong;
  return std::nullopt;
}

std::vector<double> image_blurs(const CalibrateOptions& options) {
  std::vector<double> sigmas{options.screen_sigma, options.support_sigma};
  for (const auto* levels : {&options.coarse, &options.fine}) {
    for (const Level& level : *levels) sigmas.push_back(level.sigma);
  }
  if (options.check_intrinsics) {
    const std::vector<double> further = intrinsics_blurs();
    sigmas.insert(sigmas.end(), further.begin(), further.end());
  }
  return sigmas;
}

CalibrationResult calibrate(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                            const Eigen::Isometry3d& T_refcam_lidar_start,
                            const CalibrateOptions& options) {
  Calibration calibration(scenes, cameras, T_refcam_lidar_start, options);
  CalibrationResult result =
      run_attempt(calibration, T_refcam_lidar_start, scenes.size(), options, kPriorScale);
  // Too few places are too few at every pose.
  const bool enough = effective_scenes(calibration.similarity()) >= kMinEffectiveScenes;
  if (!result.usable() && enough && options.restarts > 0 && result.points > 0) {
    const CalibrationResult held =
        run_attempt(calibration, T_refcam_lidar_start, scenes.size(), options, kRetryPriorScale);
    // At the same place everything is as wrong as before.
    if (held.usable() && !is_same_maximum(held.T_refcam_lidar, result.T_refcam_lidar)) {
      result = held;
    }
  }
  if (result.usable()) result.split_half = calibration.split_half(result.T_refcam_lidar);
  result.evaluations += calibration.evaluations();
  return result;
}

}  // namespace infuse::calibration
