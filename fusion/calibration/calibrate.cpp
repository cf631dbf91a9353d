#include "fusion/calibration/calibrate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>

namespace infuse::calibration {
namespace {

using geometry::Vector6;

constexpr double kNearRotation = 0.5 * M_PI / 180;
constexpr double kNearTranslation = 0.08;
constexpr double kFarthest = 4;  // standard deviations of the start's translation

/// Even in [−1, 1]; the standard's distributions differ between libraries.
double draw(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0; }

/// The start itself, and what is drawn around it.
std::vector<Eigen::Isometry3d> draw_starts(const Eigen::Isometry3d& T,
                                           const CalibrateOptions& options) {
  std::mt19937_64 random(options.seed);
  std::vector<Eigen::Isometry3d> starts{T};
  while (static_cast<int>(starts.size()) < options.starts) {
    Vector6 xi;
    for (int k = 0; k < 6; ++k) {
      xi(k) = draw(random) * (k < 3 ? options.start_rotation : 0.5 * options.start_translation);
    }
    starts.push_back(geometry::exp(xi) * T);
  }
  return starts;
}

bool near(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Vector6 apart = geometry::log(a * b.inverse());
  return apart.head<3>().norm() <= kNearRotation && apart.tail<3>().norm() <= kNearTranslation;
}

/// Where the coarse searches ended; an end that is worse than another is counted, not refined.
struct CoarseEnds {
  std::vector<Eigen::Isometry3d> ends;
  Eigen::Isometry3d best;
};

CoarseEnds search_coarsely(CoarseToFine& search, const Eigen::Isometry3d& start,
                           const CalibrateOptions& options) {
  CoarseEnds out;
  for (const Eigen::Isometry3d& T : draw_starts(start, options)) {
    out.ends.push_back(search.climb(T, options.coarse).T_head_lidar);
  }
  const Level& judge = options.coarse.empty() ? options.fine.front() : options.coarse.back();
  out.best = out.ends.front();
  for (const Eigen::Isometry3d& end : out.ends) out.best = search.better(out.best, end, judge);
  return out;
}

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

/// Why the result cannot be used, or an empty text.
std::string judge(const CalibrationResult& result, const Maximum& maximum, double moved,
                  const CalibrateOptions& options) {
  if (!maximum.usable()) return maximum.reason;
  if (!result.uncertainty.usable()) return result.uncertainty.reason;
  if (result.support < options.min_support) {
    return print(
        "the scenes do not support it: only %.0f %% of small wrong rotations make them fit worse "
        "(%.0f %% expected); do pictures and sweeps belong together?",
        100 * result.support, 100 * options.min_support);
  }
  if (2 * result.agreed < result.starts) {
    return print("only %d of %d starts ended at the same place", result.agreed, result.starts);
  }
  if (moved > kFarthest * options.start_translation) {
    return print("it moved %.2f m from the start, whose translation is known to %.2f m", moved,
                 options.start_translation);
  }
  return {};
}

}  // namespace

std::optional<std::string> CalibrateOptions::invalid() const {
  for (const TermOptions& term : terms) {
    if (auto wrong = term.invalid()) return "terms: " + *wrong;
  }
  if (fine.empty()) return "fine must have at least one level";
  for (const auto* levels : {&coarse, &fine}) {
    for (const Level& level : *levels) {
      if (auto wrong = level.invalid()) return "level: " + *wrong;
    }
  }
  if (starts < 1) return "starts must be at least 1";
  if (!(start_rotation >= 0)) return "start_rotation must not be negative";
  if (!(start_translation > 0)) return "start_translation must be positive";
  if (!(uncertainty_sigma >= 0)) return "uncertainty_sigma must not be negative";
  if (!(min_support >= 0 && min_support <= 1)) return "min_support must lie in 0 … 1";
  if (auto wrong = maximize.invalid()) return "maximize: " + *wrong;
  if (auto wrong = visibility.invalid()) return "visibility: " + *wrong;
  return std::nullopt;
}

CalibrationResult calibrate(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                            const Eigen::Isometry3d& T_head_lidar_start,
                            const CalibrateOptions& options) {
  CoarseToFine search(scenes, cameras,
                      options.terms.empty() ? named_measures().front().terms : options.terms,
                      options.visibility, options.maximize, T_head_lidar_start.translation(),
                      options.start_translation);
  const CoarseEnds coarse = search_coarsely(search, T_head_lidar_start, options);
  const Maximum maximum = search.climb(coarse.best, options.fine);

  CalibrationResult result{.T_head_lidar = maximum.T_head_lidar};
  result.starts = static_cast<int>(coarse.ends.size());
  result.agreed =
      static_cast<int>(std::count_if(coarse.ends.begin(), coarse.ends.end(), [&](const auto& end) {
        return near(end, result.T_head_lidar);
      }));

  const VisiblePoints points = search.visible(std::span(&result.T_head_lidar, 1), 0);
  Objective finest = search.objective(points, options.fine.back().sigma);
  result.points = points.size();
  result.value = finest.evaluate(result.T_head_lidar, false).estimate.value;
  result.value_at_start = finest.evaluate(T_head_lidar_start, false).estimate.value;

  Objective smooth = search.objective(points, options.uncertainty_sigma);
  result.uncertainty = estimate_uncertainty(smooth, result.T_head_lidar);
  result.scenes =
      scene_support(search, result.T_head_lidar, scenes.size(), options.uncertainty_sigma);
  result.support = mean_support(result.scenes);
  result.evaluations = search.evaluations() + finest.evaluations() + smooth.evaluations();
  const double moved =
      (result.T_head_lidar.translation() - T_head_lidar_start.translation()).norm();
  result.reason = judge(result, maximum, moved, options);
  return result;
}

}  // namespace infuse::calibration
