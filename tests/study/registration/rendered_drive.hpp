#pragma once

#include "fixtures/simulator/simulation.hpp"
#include "tests/study/registration/posed_scan.hpp"

namespace infuse::study {

/// Scans of one drive through an invented town.
struct RenderedDrive {
  Rig rig;  ///< an HDL-64E and a ring of five cameras
  std::vector<PosedScan> scans;
};

/// How scans are rendered.
struct RenderOptions {
  bool images = true;  ///< false: sweeps only
  int threads = 2;
};

/// Renders scans at the given distances from the start of a drive, m, in ascending order. Town,
/// light, traffic and sensor noise are drawn from the seed. Nothing is written to disk.
Result<RenderedDrive> render_drive(uint64_t seed, const std::vector<double>& distances,
                                   const RenderOptions& options = {});

}  // namespace infuse::study
