#include "tests/study/registration/alignment_table.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <ostream>
#include <stdexcept>

#include "drivers/measurement/angles.hpp"
#include "fusion/registration/visual/align_scans.hpp"
#include "fusion/registration/visual/visual_alignment.hpp"
#include "tests/study/registration/rendered_drive.hpp"

namespace infuse::study {
namespace {

constexpr std::array<const char*, 4> kMethods{"GICP from the identity", "RANSAC", "VB-GICP",
                                              "mutual information"};
constexpr std::array<size_t, 4> kScans{1, 5, 10, 15};

AlignmentError error_of(bool usable, const Eigen::Isometry3d& T, const Eigen::Isometry3d& truth) {
  return {usable, (T.translation() - truth.translation()).norm(),
          geometry::rotation_log(T.linear() * truth.linear().transpose()).norm()};
}

/// The largest of the lower half, and the largest of all; 0 if there are none.
std::pair<double, double> median_and_maximum(std::vector<double> values) {
  if (values.empty()) return {0, 0};
  std::sort(values.begin(), values.end());
  return {values[(values.size() - 1) / 2], values.back()};
}

}  // namespace

void AlignmentTable::add(const std::vector<CameraMount>& cameras, const PosedScan& target,
                         const PosedScan& source, size_t scans) {
  const Eigen::Isometry3d truth = target.T_world_lidar.inverse() * source.T_world_lidar;
  const auto images_there = images_of(target, cameras), images_here = images_of(source, cameras);
  const registration::CameraLidarScan there{features::make_sweep_view(target.sweep), images_there};
  const registration::CameraLidarScan here{features::make_sweep_view(source.sweep), images_here};
  const auto add_error = [&](size_t method, bool usable, const Eigen::Isometry3d& T) {
    errors_[{scans, method}].push_back(error_of(usable, T, truth));
  };
  const auto cloud = registration::prepare_cloud(there.sweep.points);
  const auto moved = registration::prepare_cloud(here.sweep.points);
  const auto plain = registration::gicp(cloud, moved.cloud, Eigen::Isometry3d::Identity());
  add_error(0, plain.usable(), plain.T_target_source);
  const auto visual = registration::align_by_keypoints(there, here);
  if (!visual) throw std::runtime_error(visual.error().message());
  const bool bootstrapped = visual->bootstrap.usable();
  add_error(1, bootstrapped,
            bootstrapped ? visual->bootstrap.hypotheses.front().T_target_source
                         : Eigen::Isometry3d::Identity());
  add_error(2, visual->result.usable(), visual->result.T_target_source);
  const auto information = registration::align_scans_by_information(there, here);
  if (!information) throw std::runtime_error(information.error().message());
  add_error(3, information->usable(), information->T_target_source);
}

void AlignmentTable::write(std::ostream& out) const {
  out << "| scans | method | usable | translation, median | maximum | rotation, median | maximum "
         "|\n|---|---|---|---|---|---|---|\n";
  for (const auto& [key, all] : errors_) {
    std::vector<double> translation, rotation;
    for (const AlignmentError& error : all) {
      if (!error.usable) continue;
      translation.push_back(error.translation);
      rotation.push_back(error.rotation / kDegree);
    }
    const auto [t, t_max] = median_and_maximum(translation);
    const auto [r, r_max] = median_and_maximum(rotation);
    out << fmt::format("| {} | {} | {} of {} | {:.3f} m | {:.3f} m | {:.3f}° | {:.3f}° |\n",
                       key.first, kMethods[key.second], translation.size(), all.size(), t, t_max, r,
                       r_max);
  }
}

AlignmentTable simulated_alignment_table(const SimulatedTableOptions& options) {
  AlignmentTable table;
  std::vector<double> distances{0};
  for (const size_t scans : kScans) {
    distances.push_back(static_cast<double>(scans) * options.spacing);
  }
  for (int d = 0; d < options.drives; ++d) {
    const auto drive = render_drive(options.first_seed + static_cast<uint64_t>(d), distances);
    if (!drive) throw std::runtime_error(drive.error().message());
    for (size_t k = 0; k < kScans.size(); ++k) {
      table.add(drive->rig.cameras, drive->scans[0], drive->scans[k + 1], kScans[k]);
    }
  }
  return table;
}

AlignmentTable recorded_alignment_table(const RecordedScans& recorded, size_t bases) {
  AlignmentTable table;
  const auto& [cameras, scans] = recorded;
  if (scans.size() <= kScans.back()) throw std::runtime_error("the drive has too few sweeps");
  const size_t last = scans.size() - 1 - kScans.back();
  for (size_t b = 0; b < bases; ++b) {
    const size_t base = bases == 1 ? 0 : b * last / (bases - 1);
    for (const size_t distance : kScans) {
      table.add(cameras, scans[base], scans[base + distance], distance);
    }
  }
  return table;
}

}  // namespace infuse::study
