#pragma once

#include <optional>
#include <string_view>

#include "fusion/registration/visual/sift_returns.hpp"

namespace infuse::registration {

/// What a codeword describes, P 4.4.1.
enum class ScanFeature : uint8_t {
  kReflectivityGrey,  ///< reflectivity of a return and grey level of its pixel
  kFpfh,              ///< shape of the surface around a point
  kSift,              ///< image around a point
  kFpfhSift,          ///< both, one after the other
};

/// "reflectivity-grey", "fpfh", "sift", "fpfh-sift".
std::string_view name(ScanFeature feature);
std::optional<ScanFeature> find_scan_feature(std::string_view name);

/// Features of a scan and where they are.
struct ScanFeatures {
  Eigen::Matrix3Xf points;  ///< m, lidar frame, one per column
  Eigen::MatrixXf vectors;  ///< one feature per column

  size_t size() const { return static_cast<size_t>(points.cols()); }
};

/// Computes features of one kind. FPFH needs no images. Errors as `find_sift_returns`.
Result<ScanFeatures> compute_scan_features(const CameraLidarScan& scan, ScanFeature feature);

}  // namespace infuse::registration
