#include "daemon/owner/sharpness.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>
#include <span>
#include <vector>

#include "daemon/pipeline/odometry_plan.hpp"
#include "daemon/playback/deskewed_sweeps.hpp"
#include "daemon/playback/find_lidar.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "fusion/registration/lidar_trajectory.hpp"

namespace infuse::daemon {
namespace {

constexpr double kVoxel = 0.1;        // m: above the noise of ranges, below that of a wrong motion
constexpr size_t kSweepsOfPart = 10;  // a second: errors of neighbouring sweeps are dependent
enum Way : size_t { kRaw, kByAll, kByLidar, kWays };

/// Occupied voxels of clouds that are placed in one frame.
class VoxelCounter {
 public:
  void add(std::span<const float> x, std::span<const float> y, std::span<const float> z,
           const Eigen::Isometry3d& T) {
    for (size_t i = 0; i < x.size(); ++i) {
      const Eigen::Vector3d at = T * Eigen::Vector3d(x[i], y[i], z[i]);
      keys_.push_back(key(at.x()) << 42 | key(at.y()) << 21 | key(at.z()));
    }
  }
  /// Adds the voxels of a part.
  void merge(const VoxelCounter& part) {
    keys_.insert(keys_.end(), part.keys_.begin(), part.keys_.end());
  }
  size_t count() {
    std::ranges::sort(keys_);
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
    return keys_.size();
  }
  void clear() { keys_.clear(); }

 private:
  /// 100 km to either side.
  static uint64_t key(double m) {
    constexpr double kHalf = 1 << 20;
    return static_cast<uint64_t>(std::clamp(std::floor(m / kVoxel) + kHalf, 0.0, 2 * kHalf - 1));
  }
  std::vector<uint64_t> keys_;
};

/// Voxels and points of the whole drive and of its parts.
class Meter {
 public:
  void add(const Sweep& sweep, const motion::DeskewedSweep& by_all,
           const motion::DeskewedSweep& by_lidar, const Eigen::Isometry3d& T_map_lidar) {
    part_[kRaw].add(sweep.x, sweep.y, sweep.z, T_map_lidar);
    part_[kByAll].add(by_all.x, by_all.y, by_all.z, T_map_lidar);
    part_[kByLidar].add(by_lidar.x, by_lidar.y, by_lidar.z, T_map_lidar);
    result_.points += sweep.size();
    ++result_.sweeps;
    if (++in_part_ == kSweepsOfPart) end_part();
  }
  void count_not_deskewed() { ++result_.not_deskewed; }

  Sharpness finish() {
    if (in_part_ > 0) end_part();
    const auto points = static_cast<double>(result_.points);
    result_.raw = static_cast<double>(whole_[kRaw].count()) / points;
    result_.deskewed = static_cast<double>(whole_[kByAll].count()) / points;
    result_.lidar = static_cast<double>(whole_[kByLidar].count()) / points;
    const size_t half = log_ratios_.size() / 2;
    result_.halves = {mean_ratio(0, half), mean_ratio(half, log_ratios_.size())};
    result_.p = probability();
    return result_;
  }

 private:
  void end_part() {
    std::array<double, kWays> voxels{};
    for (size_t way = 0; way < kWays; ++way) {
      voxels[way] = static_cast<double>(part_[way].count());
      whole_[way].merge(part_[way]);
      part_[way].clear();
    }
    log_ratios_.push_back(std::log(voxels[kByAll] / voxels[kRaw]));
    in_part_ = 0;
  }

  double mean(size_t begin, size_t end) const {
    double sum = 0;
    for (size_t i = begin; i < end; ++i) sum += log_ratios_[i];
    return end > begin ? sum / static_cast<double>(end - begin) : 0;
  }
  double mean_ratio(size_t begin, size_t end) const { return std::exp(mean(begin, end)); }

  double probability() const {
    const size_t n = log_ratios_.size();
    if (n < 3) return 1;
    const double centre = mean(0, n);
    double square = 0;
    for (const double ratio : log_ratios_) square += (ratio - centre) * (ratio - centre);
    const auto parts = static_cast<double>(n);
    const double sigma = std::sqrt(square / (parts - 1) / parts);
    if (!(sigma > 0)) return 1;
    return boost::math::cdf(boost::math::students_t(parts - 1), centre / sigma);
  }

  std::array<VoxelCounter, kWays> part_, whole_;
  std::vector<double> log_ratios_;  // by part
  size_t in_part_ = 0;
  Sharpness result_;
};

}  // namespace

Result<Sharpness> measure_sharpness(const std::filesystem::path& drive, const std::string& lidar) {
  auto setup = open_drive(drive, {}, {});
  if (!setup) return tl::unexpected(setup.error());
  const auto index = find_lidar(*setup, lidar);
  if (!index) return tl::unexpected(index.error());
  const Eigen::Isometry3d& T_vehicle_lidar = setup->rig.lidars[*index].T_vehicle_lidar;
  struct Placed {
    Eigen::Isometry3d T_map_lidar;
    motion::DeskewedSweep deskewed;
  };
  std::map<uint64_t, Placed> by_lidar;  // sweeps that wait for the other sources
  registration::LidarTrajectory trajectory(T_vehicle_lidar);
  const auto middle = [](const Sweep& sweep) { return sweep.stamp + sweep.span / 2; };
  DeskewedSweeps sweeps(plan_odometry({}, *setup, *index), T_vehicle_lidar, middle);
  Meter meter;
  const auto on_deskewed = [&](const Sweep& sweep, const motion::DeskewedSweep& deskewed) {
    const auto placed = by_lidar.find(sweep.sequence);
    if (placed == by_lidar.end()) return;
    if (deskewed.usable()) {
      meter.add(sweep, deskewed, placed->second.deskewed, placed->second.T_map_lidar);
    } else {
      meter.count_not_deskewed();
    }
    by_lidar.erase(placed);
  };
  play_lidar(
      *setup, *index,
      [&](const Sweep& sweep) {
        const registration::LidarOdometryResult& result = trajectory.add(sweep);
        if (result.usable() && trajectory.deskewed().usable())
          by_lidar[sweep.sequence] = {result.T_map_vehicle * T_vehicle_lidar,
                                      trajectory.deskewed()};
        sweeps.add_sweep(sweep);
      },
      [&](const VehicleSample& sample) { sweeps.add_sample(sample); },
      [&](const recording::DriveEvent& event) {
        sweeps.process_due(event.stamp, on_deskewed);
        return true;
      });
  sweeps.finish(on_deskewed);
  const Sharpness result = meter.finish();
  if (result.sweeps == 0) {
    return fail("no sweep is deskewed both by its lidar and by the drive's odometry",
                drive.string(), "infuse inspect says what is missing");
  }
  return result;
}

Json to_json(const Sharpness& s) {
  return {{"kind", "sharpness"},
          {"sweeps", s.sweeps},
          {"not_deskewed", s.not_deskewed},
          {"points", s.points},
          {"voxels_per_point", {{"raw", s.raw}, {"deskewed", s.deskewed}, {"lidar", s.lidar}}},
          {"ratio_of_halves", {s.halves[0], s.halves[1]}},
          {"p", s.p}};
}

std::string to_text(const Sharpness& s) {
  return fmt::format(
      "{} sweeps, {} points; occupied voxels of 10 cm per point\n"
      "  as measured                  {:.4f}\n"
      "  deskewed by all sources      {:.4f} ({:+.2f} %)\n"
      "  deskewed by the lidar alone  {:.4f} ({:+.2f} %)\n"
      "  deskewed over measured in the halves of the drive: {:.4f}, {:.4f}; by chance with p = "
      "{:.2g}\n",
      s.sweeps, s.points, s.raw, s.deskewed, 100 * (s.deskewed / s.raw - 1), s.lidar,
      100 * (s.lidar / s.raw - 1), s.halves[0], s.halves[1], s.p);
}

}  // namespace infuse::daemon
