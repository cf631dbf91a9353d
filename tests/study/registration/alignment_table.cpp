#include "tests/study/registration/alignment_table.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
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

constexpr double kWrong = 0.5;              // m; a recorded drive's reference errs by 0.3
constexpr double kWrongRotation = kDegree;  // P figs. 4.18 to 4.21

AlignmentError error_of(const registration::RegistrationResult& result,
                        const Eigen::Isometry3d& truth) {
  const Eigen::Isometry3d& T = result.T_target_source;
  AlignmentError out{result.usable(),
                     (T.translation() - truth.translation()).norm(),
                     geometry::rotation_log(T.linear() * truth.linear().transpose()).norm(),
                     {}};
  const geometry::Vector6 error = geometry::log(truth * T.inverse());
  if (result.free_directions < 6 && !result.information.isZero())
    out.normalised = error.dot(result.information * error) / (6 - result.free_directions);
  return out;
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
  const auto add_error = [&](size_t method, const registration::RegistrationResult& result) {
    errors_[{scans, method}].push_back(error_of(result, truth));
  };
  const auto cloud = registration::prepare_cloud(there.sweep.points);
  const auto moved = registration::prepare_cloud(here.sweep.points);
  add_error(0, registration::gicp(cloud, moved.cloud, Eigen::Isometry3d::Identity()));
  const auto visual = registration::align_by_keypoints(there, here);
  if (!visual) throw std::runtime_error(visual.error().message());
  registration::RegistrationResult bootstrap;
  if (visual->bootstrap.usable()) {
    bootstrap.converged = true;
    bootstrap.reason = "";
    bootstrap.T_target_source = visual->bootstrap.hypotheses.front().T_target_source;
  }
  add_error(1, bootstrap);
  add_error(2, visual->result);
  const auto information = registration::align_scans_by_information(there, here);
  if (!information) throw std::runtime_error(information.error().message());
  add_error(3, *information);
}

void AlignmentTable::write(std::ostream& out) const {
  out << "| scans | method | usable | wrong | translation, median | maximum | rotation, median | "
         "maximum | squared error over covariance a direction, median | mean |\n"
         "|---|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [key, all] : errors_) {
    std::vector<double> translation, rotation, normalised;
    size_t wrong = 0;
    double sum = 0;
    for (const AlignmentError& error : all) {
      if (!error.usable) continue;
      const bool is_wrong = error.translation > kWrong || error.rotation > kWrongRotation;
      wrong += is_wrong ? 1 : 0;
      translation.push_back(error.translation);
      rotation.push_back(error.rotation / kDegree);
      if (is_wrong) continue;
      if (!error.normalised) continue;
      normalised.push_back(*error.normalised);
      sum += *error.normalised;
    }
    const std::string over_covariance =
        normalised.empty() ? "– | –"
                           : fmt::format("{:.2f} | {:.2f}", median_and_maximum(normalised).first,
                                         sum / static_cast<double>(normalised.size()));
    const auto [t, t_max] = median_and_maximum(translation);
    const auto [r, r_max] = median_and_maximum(rotation);
    out << fmt::format(
        "| {} | {} | {} of {} | {} | {:.3f} m | {:.3f} m | {:.3f}° | {:.3f}° | {} |\n", key.first,
        kMethods[key.second], translation.size(), all.size(), wrong, t, t_max, r, r_max,
        over_covariance);
  }
}

std::string cycle_errors(const RecordedScans& recorded, size_t length) {
  const std::vector<CameraMount>& cameras = recorded.cameras;
  const std::vector<PosedScan>& scans = recorded.scans;
  double sum = 0, largest = 0, translation = 0;
  size_t cycles = 0, missing = 0;
  for (size_t first = 2; first + 2 * length < scans.size(); first += length) {
    const auto align = [&](size_t target, size_t source) {
      const auto images_there = images_of(scans[target], cameras);
      const auto images_here = images_of(scans[source], cameras);
      auto aligned = registration::align_by_keypoints(
          {features::make_sweep_view(scans[target].sweep), images_there},
          {features::make_sweep_view(scans[source].sweep), images_here});
      if (!aligned) throw std::runtime_error(aligned.error().message());
      return aligned->result;
    };
    const auto there = align(first, first + length);
    const auto on = align(first + length, first + 2 * length);
    const auto both = align(first, first + 2 * length);
    if (!there.usable() || !on.usable() || !both.usable()) {
      ++missing;
      continue;
    }
    const geometry::Vector6 error =
        geometry::log(there.T_target_source * on.T_target_source * both.T_target_source.inverse());
    const geometry::Matrix6 covariance =
        there.covariance + geometry::transform_covariance(there.T_target_source, on.covariance) +
        both.covariance;
    const double normalised = error.dot(covariance.ldlt().solve(error)) / 6;
    sum += normalised;
    largest = std::max(largest, normalised);
    translation += error.tail<3>().squaredNorm();
    ++cycles;
  }
  const auto count = static_cast<double>(std::max<size_t>(1, cycles));
  return fmt::format(
      "VB-GICP around {} cycles of {}, {} and {} sweeps ({} not usable): squared error over its "
      "covariance a direction {:.2f}, at most {:.2f}; rms {:.1f} mm",
      cycles, length, length, 2 * length, missing, sum / count, largest,
      1000 * std::sqrt(translation / count));
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

AlignmentTable recorded_alignment_table(const RecordedScans& recorded, size_t step) {
  constexpr size_t kFarthest = 20, kGroup = 5;
  AlignmentTable table;
  const auto& [cameras, scans] = recorded;
  if (scans.size() < 3) throw std::runtime_error("the drive has too few sweeps");
  for (size_t target = 1; target + 1 < scans.size(); target += step) {
    for (size_t distance = 1; distance <= kFarthest; ++distance) {
      if (target + distance >= scans.size()) break;
      table.add(cameras, scans[target], scans[target + distance],
                (distance + kGroup - 1) / kGroup * kGroup);
    }
  }
  return table;
}

}  // namespace infuse::study
