#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/calibration/feature.hpp"
#include "fusion/calibration/visible_points.hpp"
#include "fusion/dependence/histogram_measures.hpp"

namespace infuse::calibration {

using dependence::Measure;

/// How a measure of dependence is estimated.
enum class Estimator {
  kHistogram,      ///< joint histogram, cubic B-spline window, P(3.17)
  kKernelDensity,  ///< the same, Gaussian kernel of Silverman's width, P(3.15–3.17); no gradient
  kLsmi,           ///< LSMI, I(2.7–2.8), of several features jointly
  kBlsmi,          ///< bagged LSMI, I(2.9), of several features jointly
};

/// Measure that is prepared with the lidar's values once and evaluated with the image's at every
/// pose.
class DependenceTerm {
 public:
  virtual ~DependenceTerm() = default;

  /// Evaluates the measure. `image`: values 0 … 1, one per point (whether it is compared or not),
  /// feature after feature. A `gradient` of the same length receives the derivative by every image
  /// value; terms without one (KDE) fill it with zero.
  virtual dependence::Estimate evaluate(std::span<const float> image,
                                        std::span<float> gradient) = 0;

  /// Number of points that are compared.
  virtual size_t sample_count() const = 0;
};

/// Summand of an objective: a measure between one lidar feature and one image feature, or, for LSMI
/// and BLSMI, between several of each jointly.
struct TermOptions {
  Measure measure = Measure::kMutualInformation;  ///< of LSMI it is squared-loss mutual information
  Estimator estimator = Estimator::kHistogram;
  std::vector<LidarFeature> lidar{LidarFeature::kRelativeReflectivity};
  std::vector<ImageFeature> image{ImageFeature::kLocalGrey};
  double weight = 1;          ///< in the sum; 1 by definition of the others' weights
  int bins = kHistogramBins;  ///< of each side of the joint histogram
  bool equalize = true;       ///< lidar feature by rank among all points in view
  int bags = 100;             ///< of kBlsmi; I 4.4.5: 50 and 100 are accurate, too
  /// Makes the term in place of `measure`, for measures that are not among those.
  std::function<std::unique_ptr<DependenceTerm>(const TermOptions&, const VisiblePoints&)> make;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Returns the indices of the points that a term compares: those whose lidar features have a value.
/// A depth edge that is not compared (`features::kNotCompared`) excludes a point only where it is
/// the term's only lidar feature; among several features it counts as no edge.
std::vector<uint32_t> select_term_points(const TermOptions& options, const VisiblePoints& points);

/// Makes a term of the points' features.
std::unique_ptr<DependenceTerm> make_term(const TermOptions& options, const VisiblePoints& points);

}  // namespace infuse::calibration
