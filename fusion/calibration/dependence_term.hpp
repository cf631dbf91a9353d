#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/calibration/feature.hpp"
#include "fusion/calibration/visible_points.hpp"
#include "fusion/dependence/estimate.hpp"

namespace infuse::calibration {

/// How dependence between lidar and image features is measured.
enum class MeasureKind {
  kMutualInformation,     ///< P(3.17), cubic B-spline window
  kMutualInformationKde,  ///< P(3.15–3.17), Gaussian kernel of Silverman's width; no gradient
  kNormalisedMutualInformation,   ///< I(4.2)
  kChiSquared,                    ///< P(3.25)
  kSquaredLossMutualInformation,  ///< discretised SMI, I(4.3)
  kLsmi,                          ///< LSMI, I(2.7–2.8), of features together
  kBlsmi,                         ///< bagged LSMI, I(2.9), of features together
};

/// A measure prepared with the lidar's side, and asked with the image's at every hypothesis.
class DependenceTerm {
 public:
  virtual ~DependenceTerm() = default;

  /// The measure with the image's values (0 … 1), one a point, whether it takes part or not,
  /// feature after feature. With a `gradient` of the same length also its derivative by every image
  /// value; terms without one (KDE) leave it zero.
  virtual dependence::Estimate evaluate(std::span<const float> image,
                                        std::span<float> gradient) = 0;

  /// How many points take part.
  virtual size_t sample_count() const = 0;
};

/// One summand of an objective: a measure between one lidar feature and one image feature; of the
/// measures that can, between several features each, taken together.
struct TermOptions {
  MeasureKind measure = MeasureKind::kMutualInformation;
  std::vector<LidarFeature> lidar{LidarFeature::kRelativeReflectivity};
  std::vector<ImageFeature> image{ImageFeature::kLocalGrey};
  double weight = 1;     ///< of the measure in the sum
  int bins = 16;         ///< a side, of the joint histogram
  bool equalize = true;  ///< the lidar feature by rank among all points in view
  int bags = 100;        ///< of kBlsmi
  /// Makes the term in place of `measure`, for measures that are not among those.
  std::function<std::unique_ptr<DependenceTerm>(const TermOptions&, const VisiblePoints&)> make;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Indices of the points that take part in a term. A return without a depth edge near it is none to
/// compare where edges are all that is compared, and one without an edge where several features are
/// taken together.
std::vector<uint32_t> select_term_points(const TermOptions& options, const VisiblePoints& points);

/// Prepares a term with the points' features.
std::unique_ptr<DependenceTerm> make_term(const TermOptions& options, const VisiblePoints& points);

}  // namespace infuse::calibration
