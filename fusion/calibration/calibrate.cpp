#include "fusion/calibration/calibrate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>

#include "fusion/calibration/free_intrinsics.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "fusion/calibration/pose_score.hpp"
#include "fusion/calibration/thin_scenes.hpp"

namespace infuse::calibration {
namespace {

using geometry::Vector6;

constexpr double kNearRotation = 0.3 * M_PI / 180;
constexpr double kNearTranslation = 0.04;
constexpr double kAlike = 0.1;   // rad: turned further, pictures of other places fit as well
constexpr int kDrawnEach = 40;   // poses drawn for one that climbs
constexpr int kMostRounds = 4;   // of restarts that each found a better place
constexpr double kFree = 1;      // times the anchors of the levels
constexpr double kHeld = 3;      // the same, where the first attempt came to nothing
constexpr int kReturning = 4;    // one restart in so many must lead back
constexpr double kFarthest = 3;  // standard deviations of the start's translation; 97 % lie nearer

/// Even in [−1, 1]; the standard's distributions differ between libraries.
double draw(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0; }

bool near(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Vector6 apart = geometry::log(a * b.inverse());
  return apart.head<3>().norm() <= kNearRotation && apart.tail<3>().norm() <= kNearTranslation;
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
std::vector<Eigen::Isometry3d> best_of(std::vector<Scored>& poses, size_t most) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const Scored& a, const Scored& b) { return a.score > b.score; });
  std::vector<Eigen::Isometry3d> best;
  for (size_t k = 0; k < std::min(most, poses.size()); ++k) best.push_back(poses[k].T);
  return best;
}

/// Those of the default measure, of the terms that are given, or what is given.
std::vector<TermOptions> leading(const CalibrateOptions& options) {
  if (!options.leading.empty()) return options.leading;
  return options.terms.empty() ? named_measures().front().leading : options.terms;
}

std::vector<TermOptions> both(std::vector<TermOptions> terms,
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
        start_(start),
        options_(options),
        terms_(options.terms.empty() ? named_measures().front().terms : options.terms),
        leading_(leading(options)),
        images_(scenes, both(terms_, leading_), all_sigmas(options)),
        margin_(options.screen.half_width * std::sqrt(3.0)),
        few_(thin_scenes(scenes, cameras, start, margin_, options.screen_points)),
        some_(thin_scenes(scenes, cameras, start, margin_, options.coarse_points)),
        most_(thin_scenes(scenes, cameras, start, margin_, options.fine_points, true)),
        search_(most_, cameras, terms_, images_, options.visibility, options.maximize, known(),
                options.start_translation),
        lead_(most_, cameras, leading_, images_, options.visibility, options.maximize, known(),
              options.start_translation),
        coarse_(some_, cameras, leading_, images_, options.visibility, options.maximize, known(),
                options.start_translation) {}

  CoarseToFine& search() { return search_; }
  CoarseToFine& lead() { return lead_; }

  /// Where climbs came to rest, and how many of the last round led back there.
  struct Rest {
    Eigen::Isometry3d T;
    int returned = 0;
    bool settled = true;  // the last round found nothing better
  };

  /// The end of the coarse climbs that scores best; `held` multiplies the levels' anchors.
  Eigen::Isometry3d find_basin(double held) {
    VisibilityOptions open = options_.visibility;
    open.occlusion_cell = 0;
    PoseScore quick(few_, cameras_, leading_, open, images_, options_.screen_sigma,
                    options_.screen.half_width > kAlike, options_.maximize.stop);
    std::vector<Eigen::Isometry3d> poses =
        screen_rotations(start_, options_.screen, std::ref(quick));
    evaluations_ += quick.evaluations();
    for (Level level : options_.coarse) {
      level.anchor *= held;
      poses = climb_all(poses, level);
    }
    return poses.front();
  }

  /// Climbs again from around `T`; where that leads to a better place, from around that. Gives back
  /// where it came to rest, and how many of the last round's climbs led back there.
  Rest settle(const Eigen::Isometry3d& T) {
    if (options_.restarts == 0) return {.T = T};
    std::mt19937_64 random(options_.seed);
    PoseScore judge(some_, cameras_, leading_, options_.visibility, images_,
                    options_.coarse.back().sigma, false, options_.maximize.stop);
    Rest rest{.T = T};
    for (int round = 0; round < kMostRounds; ++round) {
      const double score = judge(rest.T);
      rest.returned = 0;
      rest.settled = false;
      std::optional<Eigen::Isometry3d> better;
      for (const Eigen::Isometry3d& start : draw_around(rest.T, random)) {
        if (better) break;
        const Eigen::Isometry3d end = coarse_.climb(start, restart_levels()).T_head_lidar;
        if (near(end, rest.T)) {
          ++rest.returned;
        } else if (judge(end) > score) {
          better = end;
        }
      }
      if (!better) {
        rest.settled = true;
        break;
      }
      rest.T = *better;
    }
    evaluations_ += judge.evaluations();
    return rest;
  }

  /// The scenes are halved at random; how far apart do the halves come to rest?
  std::optional<geometry::Matrix6> split_half(const Eigen::Isometry3d& T) {
    if (options_.splits == 0 || some_.size() < 2) return std::nullopt;
    std::mt19937_64 random(options_.seed);
    geometry::Matrix6 sum = geometry::Matrix6::Zero();
    for (int split = 0; split < options_.splits; ++split) {
      std::vector<size_t> order(some_.size());
      std::iota(order.begin(), order.end(), size_t{0});
      for (size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[random() % k]);
      const std::span<const size_t> all(order);
      const Eigen::Isometry3d one = climb_with(T, all.first(all.size() / 2));
      const Eigen::Isometry3d other = climb_with(T, all.subspan(all.size() / 2));
      const Vector6 apart = geometry::log(one * other.inverse());
      sum += apart * apart.transpose();
    }
    return 0.25 / options_.splits * sum;
  }

  /// What the scenes say of the cameras and of the clock.
  std::vector<ModelDoubt> doubts(Objective& finest, const Eigen::Isometry3d& T,
                                 const Uncertainty& uncertainty) {
    std::vector<ModelDoubt> all = check_model(finest, T, cameras_, most_, uncertainty);
    for (size_t c = 0; options_.check_intrinsics && c < cameras_.size(); ++c) {
      const auto freed = free_intrinsics(most_, cameras_, c, leading_, images_, options_.visibility,
                                         T, options_.maximize.stop);
      const auto gross = freed ? gross_doubt(*freed, cameras_, c) : std::nullopt;
      if (!gross) continue;
      std::erase_if(all, [&](const ModelDoubt& doubt) { return doubt.what == gross->what; });
      all.insert(all.begin(), *gross);
    }
    return all;
  }

  int evaluations() const {
    return evaluations_ + search_.evaluations() + lead_.evaluations() + coarse_.evaluations();
  }

 private:
  /// The two finest of the coarse levels.
  std::span<const Level> restart_levels() const {
    const std::span<const Level> levels(options_.coarse);
    return levels.last(std::min<size_t>(2, levels.size()));
  }

  /// Poses from around `T`: of many that are drawn, those that score best.
  std::vector<Eigen::Isometry3d> draw_around(const Eigen::Isometry3d& T, std::mt19937_64& random) {
    PoseScore quick(few_, cameras_, leading_, options_.visibility, images_,
                    restart_levels().front().sigma, false, options_.maximize.stop);
    std::vector<Scored> drawn;
    for (int k = 0; k < kDrawnEach * options_.restarts; ++k) {
      Vector6 xi;
      for (int axis = 0; axis < 6; ++axis) {
        xi(axis) =
            draw(random) * (axis < 3 ? options_.restart_rotation : options_.restart_translation);
      }
      const Eigen::Isometry3d pose = geometry::exp(xi) * T;
      drawn.push_back({pose, quick(pose)});
    }
    evaluations_ += quick.evaluations();
    return best_of(drawn, static_cast<size_t>(options_.restarts));
  }

  /// The finest coarse levels with some of the scenes alone.
  Eigen::Isometry3d climb_with(const Eigen::Isometry3d& T, std::span<const size_t> scenes) {
    std::vector<Scene> part(some_.size());
    for (size_t s = 0; s < some_.size(); ++s) part[s].camera = some_[s].camera;
    for (const size_t s : scenes) part[s] = some_[s];
    CoarseToFine search(part, cameras_, leading_, images_, options_.visibility, options_.maximize,
                        known(), options_.start_translation);
    const Eigen::Isometry3d end = search.climb(T, restart_levels()).T_head_lidar;
    evaluations_ += search.evaluations();
    return end;
  }

  /// Climbs one level from each; gives back the best ends, best first.
  std::vector<Eigen::Isometry3d> climb_all(const std::vector<Eigen::Isometry3d>& from,
                                           const Level& level) {
    PoseScore judge(some_, cameras_, leading_, options_.visibility, images_, level.sigma, false,
                    options_.maximize.stop);
    std::vector<Scored> ends;
    for (const Eigen::Isometry3d& T : from) {
      const Eigen::Isometry3d end = coarse_.climb(T, std::span(&level, 1)).T_head_lidar;
      ends.push_back({end, judge(end)});
    }
    evaluations_ += judge.evaluations();
    return best_of(ends, static_cast<size_t>(level.survivors));
  }

  Eigen::Vector3d known() const { return start_.inverse().translation(); }

  std::span<const RigCamera> cameras_;
  Eigen::Isometry3d start_;
  const CalibrateOptions& options_;
  std::vector<TermOptions> terms_, leading_;
  ImagePyramid images_;
  double margin_;
  std::vector<Scene> few_, some_, most_;
  CoarseToFine search_, lead_, coarse_;
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
std::string print(const char* format, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

std::string doubt_text(const ModelDoubt& doubt) {
  const std::string by = doubt.value == 0 ? ""
                                          : print("%+.2g%s%s, ", doubt.value,
                                                  *doubt.unit == '\0' ? "" : " ", doubt.unit);
  return print("lidar and pictures would fit better with another %s (%s%.0f sigma)",
               doubt.what.c_str(), by.c_str(), std::abs(doubt.significance));
}

/// Why the result cannot be used, or an empty text.
std::string judge(const CalibrationResult& result, const Maximum& maximum, double moved,
                  const CalibrateOptions& options) {
  if (!maximum.usable()) return maximum.reason;
  if (!result.uncertainty.usable()) return result.uncertainty.reason;
  for (const ModelDoubt& doubt : result.doubts) {
    if (doubt.gross) return doubt_text(doubt);  // what follows may come of it
  }
  if (result.support < options.min_support) {
    return print(
        "the scenes do not support it: only %.0f %% of small wrong rotations make them fit worse "
        "(%.0f %% expected); do pictures and sweeps belong together?",
        100 * result.support, 100 * options.min_support);
  }
  if (!result.settled) {
    return "restarts from around it kept finding better places";
  }
  if (kReturning * result.returned < result.restarts) {
    return print("only %d of %d restarts from around it led back", result.returned,
                 result.restarts);
  }
  for (const ModelDoubt& doubt : result.doubts) {
    if (doubt.serious) return doubt_text(doubt);
  }
  if (moved > kFarthest * options.start_translation) {
    return print("it moved %.2f m from the start, whose translation is known to %.2f m", moved,
                 options.start_translation);
  }
  return {};
}

/// Finds a calibration with the levels' anchors multiplied by `held`, and judges it.
CalibrationResult attempt(Calibration& calibration, const Eigen::Isometry3d& start, size_t scenes,
                          const CalibrateOptions& options, double held) {
  CalibrationResult result;
  CoarseToFine& search = calibration.search();
  const Calibration::Rest rest = calibration.settle(calibration.find_basin(held));
  const std::span<const Level> fine(options.fine);
  const Maximum led = calibration.lead().climb(rest.T, fine.first(fine.size() - 1));
  const Maximum maximum = search.climb(led.T_head_lidar, fine.last(1));
  if (options.maximize.stop.stop_requested()) {
    result.T_head_lidar = start;
    result.reason = maximum.reason;
    return result;
  }
  result.T_head_lidar = maximum.T_head_lidar;
  result.restarts = options.restarts;
  result.returned = rest.returned;
  result.settled = rest.settled;

  const VisiblePoints points = search.visible(result.T_head_lidar, fine.back().points);
  Objective finest = search.objective(points, options.fine.back().sigma);
  result.points = points.size();
  result.value = finest.evaluate(result.T_head_lidar, false).estimate.value;
  result.value_at_start = finest.evaluate(start, false).estimate.value;
  result.uncertainty = estimate_uncertainty(finest, result.T_head_lidar);
  result.doubts = calibration.doubts(finest, result.T_head_lidar, result.uncertainty);
  result.scenes =
      scene_support(calibration.lead(), result.T_head_lidar, scenes, options.support_sigma);
  result.support = mean_support(result.scenes);
  result.evaluations = finest.evaluations();
  const double moved =
      (result.T_head_lidar.inverse().translation() - start.inverse().translation()).norm();
  result.reason = judge(result, maximum, moved, options);
  return result;
}

}  // namespace

std::optional<std::string> CalibrateOptions::invalid() const {
  for (const auto* sum : {&terms, &leading}) {
    for (const TermOptions& term : *sum) {
      if (auto wrong = term.invalid()) return "terms: " + *wrong;
    }
  }
  if (coarse.empty() && (screen.kept > 0 || restarts > 0 || splits > 0)) {
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
  if (!(start_translation > 0)) return "start_translation must be positive";
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
      attempt(calibration, T_head_lidar_start, scenes.size(), options, kFree);
  const bool gross = std::any_of(result.doubts.begin(), result.doubts.end(),
                                 [](const ModelDoubt& doubt) { return doubt.gross; });
  if (!result.usable() && options.restarts > 0 && result.points > 0) {
    const CalibrationResult held =
        attempt(calibration, T_head_lidar_start, scenes.size(), options, kHeld);
    // At the same place the same camera is as wrong as before.
    const bool there = near(held.T_head_lidar, result.T_head_lidar);
    if (held.usable() && !(gross && there)) result = held;
  }
  if (result.usable()) result.split_half = calibration.split_half(result.T_head_lidar);
  result.evaluations += calibration.evaluations();
  return result;
}

}  // namespace infuse::calibration
