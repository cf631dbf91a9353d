#pragma once

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
  kCorrelation,                   ///< mean product, I(4.4): the batch form of P(3.23)
};

/// One summand of an objective: a measure between one lidar feature and one image feature.
struct TermOptions {
  MeasureKind measure = MeasureKind::kMutualInformation;
  LidarFeature lidar = LidarFeature::kRelativeReflectivity;
  ImageFeature image = ImageFeature::kLocalGrey;
  double weight = 1;     ///< of the measure in the sum
  int bins = 16;         ///< a side, of the joint histogram
  bool equalize = true;  ///< the lidar feature by rank among all points in view

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// A measure prepared with the lidar's side, and asked with the image's at every hypothesis.
class DependenceTerm {
 public:
  virtual ~DependenceTerm() = default;

  /// The measure with one image value (0 … 1) a point, whether it takes part or not. With a
  /// `gradient` of the same length also its derivative by every image value; terms without one
  /// (KDE) leave it zero.
  virtual dependence::Estimate evaluate(std::span<const float> image,
                                        std::span<float> gradient) = 0;

  /// How many points take part.
  virtual size_t samples() const = 0;
};

/// Indices of the points that a lidar feature has something to compare of (not `kNotCompared`).
std::vector<uint32_t> taking_part(std::span<const float> lidar);

/// Prepares a term with the points' features.
std::unique_ptr<DependenceTerm> make_term(const TermOptions& options, const VisiblePoints& points);

/// What `infuse calibrate --measure NAME` offers: a name for a sum of terms.
struct NamedMeasure {
  const char* name;
  const char* description;
  std::vector<TermOptions> terms;
  bool equalize_image;  ///< SceneOptions::equalize
  bool has_gradient;
};

/// All of them, the default first.
std::span<const NamedMeasure> named_measures();

/// Null where there is none of that name.
const NamedMeasure* find_measure(const std::string& name);

}  // namespace infuse::calibration
