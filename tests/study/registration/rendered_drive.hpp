#pragma once

#include "drivers/velodyne/velodyne_maker.hpp"
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

/// A lidar on the roof, 1 m ahead of the rear axle and so high, m; one ray for each pulse.
simulator::LidarOptions roof_lidar(velodyne::Model model, double height);

/// A turn of the first lidar about `time` (s). Every return is moved to where it would have been
/// measured at that time, by the true motion; the noise of its range is kept.
Sweep deskewed_turn(simulator::Simulation& simulation, double time);

/// Time at which the vehicle has driven so far (m), s; the end of the drive if it never does.
double time_of(const simulator::Simulation& simulation, double distance);

/// Renders scans at the given distances from the start of a drive, m, in ascending order. Town,
/// light, traffic and sensor noise are drawn from the seed. Nothing is written to disk.
Result<RenderedDrive> render_drive(uint64_t seed, const std::vector<double>& distances,
                                   const RenderOptions& options = {});

}  // namespace infuse::study
