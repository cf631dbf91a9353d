#pragma once

#include <filesystem>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "tests/study/registration/posed_scan.hpp"

namespace infuse::study {

/// Scans of a recorded drive.
struct RecordedScans {
  std::vector<CameraMount> cameras;
  std::vector<PosedScan> scans;
};

/// Reads all sweeps of a drive, deskewed to the images nearest to them, as `infuse align` does.
/// `poses` is a file of rows T_first_k as KITTI's, one per sweep, lines with # left out.
Result<RecordedScans> read_recorded_scans(const std::filesystem::path& drive,
                                          const std::filesystem::path& poses);

}  // namespace infuse::study
