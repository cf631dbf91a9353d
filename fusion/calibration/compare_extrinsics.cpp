#include "fusion/calibration/compare_extrinsics.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "fusion/calibration/image_pyramid.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "fusion/calibration/scene_similarity.hpp"

namespace infuse::calibration {
namespace {

constexpr size_t kMinComparedPoints = 200;  // number of points of a scene under both poses
// It is derived from CompareOptions::max_p_value: signs of five scenes show no less than 2 / 2⁵.
constexpr size_t kMinIndependentScenes = 6;
constexpr double kCentreStep = 0.5;        // px, of differences by the principal point
constexpr double kSimilar = 0.5;           // of two scenes of one place
constexpr size_t kMaxEnumerated = 16;      // bounds time: values whose sign patterns are all tried
constexpr size_t kDrawnPatterns = 20'000;  // bounds time: 5 % is drawn to ± 0.15 %

/// Mean of the image edges under the depth edges, weighted by how strong these are.
double edge_gradient(Objective& measure, const Eigen::Isometry3d& T, size_t edge_term) {
  const Objective::Samples samples = measure.samples(T, edge_term);
  double sum = 0, weights = 0;
  for (size_t i = 0; i < samples.lidar.size(); ++i) {
    if (!(samples.lidar[i] > 0) || std::isnan(samples.image[i])) continue;
    const auto weight = static_cast<double>(samples.lidar[i]);
    sum += weight * static_cast<double>(samples.image[i]);
    weights += weight;
  }
  return weights > 0 ? sum / weights : 0;
}

/// The cameras with every principal point moved by (u, v), px.
std::vector<RigCamera> with_centre_moved(std::span<const RigCamera> cameras, double u, double v) {
  std::vector<RigCamera> moved(cameras.begin(), cameras.end());
  for (RigCamera& camera : moved) {
    CameraIntrinsics model = camera.model.intrinsics();
    model.cx += u;
    model.cy += v;
    camera.model = geometry::CameraModel(model);
  }
  return moved;
}

SceneFit difference(const SceneFit& b, const SceneFit& a) {
  return {b.edge_gradient - a.edge_gradient, b.dependence - a.dependence};
}

SceneFit mean_of(const std::vector<SceneFit>& fits) {
  SceneFit mean;
  for (const SceneFit& fit : fits) {
    mean.edge_gradient += fit.edge_gradient / static_cast<double>(fits.size());
    mean.dependence += fit.dependence / static_cast<double>(fits.size());
  }
  return mean;
}

/// Lead of pose b over pose a in a scene, and its derivatives by the principal point, 1/px.
struct Lead {
  SceneFit value, by_u, by_v;
};

/// Factor that makes the root mean square of the leads one; zero where all are zero.
double scale_of(const std::vector<Lead>& leads, double SceneFit::*value) {
  double squares = 0;
  for (const Lead& lead : leads) squares += lead.value.*value * lead.value.*value;
  return squares > 0 ? std::sqrt(static_cast<double>(leads.size()) / squares) : 0;
}

}  // namespace

std::optional<std::string> CompareOptions::invalid() const {
  if (!(sigma >= 0)) return "sigma must not be negative";
  if (!(max_p_value > 0 && max_p_value < 1)) return "max_p_value must be between 0 and 1";
  if (!(bias >= 0 && bias <= 100)) return "bias must be between 0 and 100 px";
  if (auto wrong = visibility.invalid()) return "visibility: " + *wrong;
  return std::nullopt;
}

std::vector<size_t> group_similar(const Eigen::MatrixXd& similarity) {
  const auto n = static_cast<size_t>(similarity.rows());
  std::vector<size_t> group(n, n);
  size_t groups = 0;
  for (size_t first = 0; first < n; ++first) {
    if (group[first] != n) continue;
    std::vector<size_t> reached{first};
    group[first] = groups;
    while (!reached.empty()) {
      const auto at = static_cast<Eigen::Index>(reached.back());
      reached.pop_back();
      for (size_t other = 0; other < n; ++other) {
        if (group[other] != n || similarity(at, static_cast<Eigen::Index>(other)) <= kSimilar) {
          continue;
        }
        group[other] = groups;
        reached.push_back(other);
      }
    }
    ++groups;
  }
  return group;
}

double sign_permutation_p_value(std::span<const double> values, uint64_t seed) {
  // Sums that are equal but for rounding count as equal.
  const double size = std::accumulate(values.begin(), values.end(), 0.0,
                                      [](double sum, double v) { return sum + std::abs(v); });
  const double least = std::abs(std::accumulate(values.begin(), values.end(), 0.0)) - 1e-12 * size;
  const bool all = values.size() <= kMaxEnumerated;
  const size_t patterns = all ? size_t{1} << values.size() : kDrawnPatterns;
  std::mt19937_64 random(seed);
  size_t as_large = all ? 0 : 1;  // of drawn ones, the given signs are one more
  for (size_t k = 0; k < patterns; ++k) {
    double sum = 0;
    uint64_t signs = all ? k : 0;
    for (size_t i = 0; i < values.size(); ++i, signs >>= 1) {
      if (!all && i % 64 == 0) signs = random();
      sum += (signs & 1) != 0 ? values[i] : -values[i];
    }
    as_large += std::abs(sum) >= least ? 1 : 0;
  }
  return static_cast<double>(as_large) / static_cast<double>(all ? patterns : patterns + 1);
}

namespace {

/// The lead in every scene that both poses show enough of; writes the fits, and which scenes.
std::vector<Lead> measure_leads(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                                const Eigen::Isometry3d& T_a, const Eigen::Isometry3d& T_b,
                                const CompareOptions& options, ExtrinsicComparison& out) {
  const std::vector<TermOptions>& terms = named_measures().front().terms;
  const auto edges = std::find_if(terms.begin(), terms.end(), [](const TermOptions& term) {
    return is_edge(term.lidar.front());
  });
  const auto edge_term = static_cast<size_t>(edges - terms.begin());
  const Eigen::Isometry3d poses[] = {T_a, T_b};
  const std::vector<RigCamera> moved[] = {
      with_centre_moved(cameras, kCentreStep, 0), with_centre_moved(cameras, -kCentreStep, 0),
      with_centre_moved(cameras, 0, kCentreStep), with_centre_moved(cameras, 0, -kCentreStep)};
  std::vector<Lead> leads;
  for (size_t s = 0; s < scenes.size(); ++s) {
    const std::span<const Scene> scene = scenes.subspan(s, 1);
    const VisiblePoints points = select_visible(scene, cameras, poses, options.visibility);
    if (points.size() < kMinComparedPoints) continue;
    const BlurredImages images(scene, cameras, terms, ImageBlur::in_angle(options.sigma));
    Objective measure(points, images, cameras, scene, terms);
    const auto fit = [&](const Eigen::Isometry3d& T) {
      return SceneFit{.edge_gradient = edge_gradient(measure, T, edge_term),
                      .dependence = measure.evaluate(T, false).estimate.value};
    };
    out.a.push_back(fit(T_a));
    out.b.push_back(fit(T_b));
    out.scenes.push_back(s);
    Lead lead{.value = difference(out.b.back(), out.a.back())};
    const auto derivative = [&](const auto& up, const auto& down) {
      measure.set_cameras(up);
      const SceneFit above = difference(fit(T_b), fit(T_a));
      measure.set_cameras(down);
      const SceneFit below = difference(fit(T_b), fit(T_a));
      const SceneFit change = difference(above, below);
      return SceneFit{change.edge_gradient / (2 * kCentreStep),
                      change.dependence / (2 * kCentreStep)};
    };
    if (options.bias > 0) {
      lead.by_u = derivative(moved[0], moved[1]);
      lead.by_v = derivative(moved[2], moved[3]);
    }
    leads.push_back(lead);
  }
  return leads;
}

/// Leads of both measures together, summed over the scenes of one place.
struct PlaceLeads {
  std::vector<double> sums;                         ///< by place; 0 without scenes
  std::vector<Eigen::Vector2d> slopes;              ///< of the sums by the principal point, 1/px
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< of their sum
  size_t places = 0;                                ///< places that have scenes
};

PlaceLeads sum_by_place(const std::vector<Lead>& leads, const std::vector<size_t>& scenes,
                        const std::vector<size_t>& place_of) {
  const double gradient_scale = scale_of(leads, &SceneFit::edge_gradient);
  const double dependence_scale = scale_of(leads, &SceneFit::dependence);
  const auto sum_of = [&](const SceneFit& fit) {
    return gradient_scale * fit.edge_gradient + dependence_scale * fit.dependence;
  };
  PlaceLeads out;
  out.sums.assign(place_of.size(), 0.0);
  out.slopes.assign(place_of.size(), Eigen::Vector2d::Zero());
  std::vector<char> seen(place_of.size(), 0);
  for (size_t k = 0; k < leads.size(); ++k) {
    const size_t of = place_of[scenes[k]];
    const Eigen::Vector2d own(sum_of(leads[k].by_u), sum_of(leads[k].by_v));
    out.sums[of] += sum_of(leads[k].value);
    out.slopes[of] += own;
    out.slope += own;
    out.places += seen[of] == 0 ? 1 : 0;
    seen[of] = 1;
  }
  return out;
}

}  // namespace

ExtrinsicComparison compare_extrinsics(std::span<const Scene> scenes,
                                       std::span<const RigCamera> cameras,
                                       const Eigen::Isometry3d& T_refcam_lidar_a,
                                       const Eigen::Isometry3d& T_refcam_lidar_b,
                                       const CompareOptions& options) {
  ExtrinsicComparison out;
  const std::vector<Lead> measured =
      measure_leads(scenes, cameras, T_refcam_lidar_a, T_refcam_lidar_b, options, out);
  out.mean_a = mean_of(out.a);
  out.mean_b = mean_of(out.b);

  PlaceLeads leads = sum_by_place(measured, out.scenes, group_similar(scene_similarity(scenes)));
  out.independent = leads.places;
  out.better = std::accumulate(leads.sums.begin(), leads.sums.end(), 0.0);
  if (out.independent < kMinIndependentScenes) {
    // Appended: for a chain of + g++ 12 warns of bounds that are kept.
    out.reason = std::to_string(out.independent);
    out.reason.append(" too few scenes of different places: ");
    out.reason.append(std::to_string(kMinIndependentScenes)).append(" are needed");
    return out;
  }
  const double feigned = options.bias * leads.slope.norm();
  out.bias_share = out.better != 0 ? std::min(1.0, feigned / std::abs(out.better)) : 0;
  if (out.bias_share == 1) return out;
  if (feigned > 0) {
    const Eigen::Vector2d displaced =
        std::copysign(options.bias, -out.better) * leads.slope.normalized();
    for (size_t s = 0; s < leads.sums.size(); ++s) {
      leads.sums[s] += leads.slopes[s].dot(displaced);
    }
  }
  std::erase(leads.sums, 0.0);
  out.p_value = sign_permutation_p_value(leads.sums, options.seed);
  return out;
}

}  // namespace infuse::calibration
