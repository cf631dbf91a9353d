#pragma once

#include "drivers/measurement/error.hpp"
#include "fusion/registration/visual/camera_lidar_scan.hpp"
#include "fusion/registration/visual/information_alignment.hpp"

namespace infuse::registration {

/// Aligns two sweeps with images by the mutual information of FPFH and SIFT, P 4.3, with
/// `learned_codebook`; needs no guess. `options.invalid()` must be empty. Errors: an image that
/// `compute_scan_features` does not take.
Result<RegistrationResult> align_scans_by_information(
    const CameraLidarScan& target, const CameraLidarScan& source,
    const InformationAlignmentOptions& options = {});

}  // namespace infuse::registration
