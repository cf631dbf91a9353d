#include "fusion/calibration/named_measures.hpp"

#include <algorithm>

namespace infuse::calibration {
namespace {

using enum dependence::Measure;
using enum Estimator;
using enum LidarFeature;

TermOptions make_term_options(Measure measure, LidarFeature lidar, ImageFeature image) {
  return {.measure = measure, .lidar = {lidar}, .image = {image}, .bins = 32, .equalize = false};
}

/// Relative reflectivity against local grey, both without unit, so that no ranks are needed.
std::vector<TermOptions> relative_terms(Measure measure) {
  return {make_term_options(measure, kRelativeReflectivity, ImageFeature::kLocalGrey)};
}

/// Reflectivity against grey, both as the sensors state them.
std::vector<TermOptions> raw_terms(Measure measure) {
  return {make_term_options(measure, kReflectivity, ImageFeature::kGrey)};
}

/// Joint features, each relative to its surroundings.
TermOptions joint_term(Estimator estimator) {
  return {.measure = kSquaredLossMutualInformation,
          .estimator = estimator,
          .lidar = {kRelativeReflectivity, kDiscontinuity},
          .image = {ImageFeature::kLocalGrey, ImageFeature::kRingEdge},
          .equalize = false};
}

/// I table 4.1: with normals, which have no surroundings to be relative to. They depend on the
/// place in the image as road and houses do, which causes a bias of 0.1° on simulated streets.
TermOptions joint_term_with_normals(Estimator estimator) {
  TermOptions term = joint_term(estimator);
  term.lidar.insert(term.lidar.end(), {kNormalX, kNormalY, kNormalZ});
  return term;
}

std::vector<NamedMeasure> make_named_measures() {
  const TermOptions edges{.lidar = {kRelativeDiscontinuity}, .image = {ImageFeature::kRingEdge}};
  // Edges have the wider convergence basin. In the final measure they are weighted by about their
  // number (on street and garage a fifth of the returns is near one): alone they hardly separate
  // turning up from standing higher, because rings seldom cross a horizontal edge.
  TermOptions downweighted_edges = edges;
  downweighted_edges.weight = 0.3;
  const std::vector<TermOptions> search{TermOptions{}, edges};
  return {
      {.name = "joint",
       .description = "MI of relative reflectivity and local grey + MI of depth edges and image "
                      "edges along the rings",
       .terms = {TermOptions{}, downweighted_edges},
       .search_terms = search,
       .equalize_image = true},
      {.name = "edges",
       .description =
           "MI of depth edges and image edges along the rings, without reflectivity (P 6.2.1)",
       .terms = {edges},
       .equalize_image = true},
      {.name = "mi",
       .description = "mutual information, P(3.17), B-spline window of 32 bins",
       .terms = relative_terms(kMutualInformation)},
      {.name = "mi-raw",
       .description = "the same of reflectivity and grey as the sensors state them",
       .terms = raw_terms(kMutualInformation)},
      {.name = "mi-kde",
       .description = "mutual information, P(3.17), Gaussian KDE on 256 bins",
       .terms = {{.estimator = kKernelDensity, .bins = 256, .equalize = false}},
       .has_gradient = false},
      {.name = "chi2", .description = "chi-squared, P(3.25)", .terms = relative_terms(kChiSquared)},
      {.name = "smi",
       .description = "discretised squared-loss mutual information, I(4.3)",
       .terms = relative_terms(kSquaredLossMutualInformation)},
      {.name = "lsmi",
       .description =
           "LSMI, I(2.8), of reflectivity and depth edges jointly with grey and image edges; "
           "started from the maximum of joint",
       .terms = {joint_term(kLsmi)},
       .search_terms = search,
       .equalize_image = true},
      {.name = "blsmi",
       .description = "the same by bagged LSMI, I(2.9), 100 bags",
       .terms = {joint_term(kBlsmi)},
       .search_terms = search,
       .equalize_image = true},
      {.name = "blsmi-normals",
       .description = "the same with surface normals, I table 4.1",
       .terms = {joint_term_with_normals(kBlsmi)},
       .search_terms = search,
       .equalize_image = true},
  };
}

const std::vector<NamedMeasure>& all_measures() {
  static const std::vector<NamedMeasure> measures = make_named_measures();
  return measures;
}

}  // namespace

std::span<const NamedMeasure> named_measures() { return all_measures(); }

const NamedMeasure* find_measure(const std::string& name) {
  const auto& measures = all_measures();
  const auto at =
      std::find_if(measures.begin(), measures.end(), [&](const auto& m) { return m.name == name; });
  return at == measures.end() ? nullptr : &*at;
}

}  // namespace infuse::calibration
