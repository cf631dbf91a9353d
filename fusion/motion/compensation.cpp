#include "fusion/motion/compensation.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/measurement/simd.hpp"

namespace infuse::motion {
namespace {

using geometry::Trajectory;
using geometry::Vector6;

constexpr size_t kBlock = 64;  // returns whose cell is looked up together

struct Extent {
  int32_t least, most;
};

INFUSE_SIMD_CLONES
Extent extent(const int32_t* offsets, size_t count) {
  int32_t least = offsets[0], most = offsets[0];
  for (size_t i = 0; i < count; ++i) {
    least = offsets[i] < least ? offsets[i] : least;
    most = offsets[i] > most ? offsets[i] : most;
  }
  return {least, most};
}

INFUSE_SIMD_CLONES
void blend(const float* start, const float* change, int32_t begin, float rate,
           const float* __restrict x, const float* __restrict y, const float* __restrict z,
           const int32_t* __restrict offset, size_t count, float* __restrict out_x,
           float* __restrict out_y, float* __restrict out_z) {
  float s[12], d[12];
  for (int i = 0; i < 12; ++i) {
    s[i] = start[i];
    d[i] = change[i];
  }
  for (size_t i = 0; i < count; ++i) {
    const float u = static_cast<float>(offset[i] - begin) * rate;
    const float px = x[i], py = y[i], pz = z[i];
    out_x[i] = ((s[0] + u * d[0]) * px + (s[1] + u * d[1]) * py) +
               ((s[2] + u * d[2]) * pz + (s[3] + u * d[3]));
    out_y[i] = ((s[4] + u * d[4]) * px + (s[5] + u * d[5]) * py) +
               ((s[6] + u * d[6]) * pz + (s[7] + u * d[7]));
    out_z[i] = ((s[8] + u * d[8]) * px + (s[9] + u * d[9]) * py) +
               ((s[10] + u * d[10]) * pz + (s[11] + u * d[11]));
  }
}

std::array<float, 12> by_row(const Eigen::Matrix4d& m) {
  std::array<float, 12> rows{};
  for (int i = 0; i < 12; ++i) rows[static_cast<size_t>(i)] = static_cast<float>(m(i / 4, i % 4));
  return rows;
}

}  // namespace

std::optional<std::string> CompensationOptions::invalid() const {
  if (!(tolerance > 0) || !(max_range > 0)) return "tolerance and max_range must be positive";
  if (max_cells < 1) return "max_cells must be at least 1";
  return std::nullopt;
}

MotionCompensator::MotionCompensator(const Eigen::Isometry3d& T_vehicle_lidar,
                                     const CompensationOptions& options)
    : T_vehicle_lidar_(T_vehicle_lidar), options_(options) {
  cells_.reserve(options.max_cells);
}

void MotionCompensator::compensate(const Sweep& sweep, const Trajectory& trajectory,
                                   Stamp reference, StraightSweep& straight) {
  straight.reference = reference;
  straight.motion = {};
  straight.reason = "";
  straight.x.resize(sweep.size());
  straight.y.resize(sweep.size());
  straight.z.resize(sweep.size());
  if (sweep.size() == 0) return;

  if (!sweep.has_times) {
    straight.reason = "the sweep has no time for each return";
  } else {
    const Extent times = extent(sweep.time_offset_ns.data(), sweep.size());
    const Stamp first = sweep.stamp + Duration(times.least);
    const Stamp last = sweep.stamp + Duration(times.most);
    straight.reason = trajectory.uncovered(std::min(first, reference), std::max(last, reference));
    if (straight.usable()) {
      straight.motion = trajectory.between(first, last);
      const Eigen::Isometry3d T_reference_map =
          (trajectory.at(reference).T_map_vehicle * T_vehicle_lidar_).inverse();
      straight.reason = build_cells(sweep, trajectory, T_reference_map, times.least, times.most);
    }
  }
  if (straight.usable()) {
    apply_cells(sweep, straight);
  } else {
    std::copy(sweep.x.begin(), sweep.x.end(), straight.x.begin());
    std::copy(sweep.y.begin(), sweep.y.end(), straight.y.begin());
    std::copy(sweep.z.begin(), sweep.z.end(), straight.z.begin());
  }
}

const char* MotionCompensator::build_cells(const Sweep& sweep, const Trajectory& trajectory,
                                           const Eigen::Isometry3d& T_reference_map, int32_t first,
                                           int32_t last) {
  cells_.clear();
  const Stamp origin = sweep.stamp;
  if (trajectory.size() < 2) return "a single pose tells no motion";
  // The piece that holds the first return; times past the last pose belong to the last piece.
  size_t next = std::clamp<size_t>(trajectory.index_at_or_after(origin + Duration(first)), 1,
                                   trajectory.size() - 1);
  int32_t begin = first;
  do {
    const geometry::StampedPose& to = trajectory[next];
    const bool final_piece = next + 1 == trajectory.size();
    const Duration until = to.stamp - origin;
    const int32_t end =
        final_piece || until.count() >= last ? last : static_cast<int32_t>(until.count());
    if (end > begin || (begin == last && cells_.empty())) {
      const char* reason = add_cells(trajectory[next - 1], to, T_reference_map, origin, begin, end);
      if (*reason != '\0') return reason;
      begin = end;
    }
    ++next;
  } while (begin < last && next < trajectory.size());
  return "";
}

const char* MotionCompensator::add_cells(const geometry::StampedPose& from,
                                         const geometry::StampedPose& to,
                                         const Eigen::Isometry3d& T_reference_map, Stamp origin,
                                         int32_t begin, int32_t end) {
  const double seconds = to_seconds(to.stamp - from.stamp);
  const Vector6 motion = geometry::log(from.T_map_vehicle.inverse() * to.T_map_vehicle);
  const double turn = motion.head<3>().norm() / seconds;
  const double speed = motion.tail<3>().norm() / seconds;
  const double reach = options_.max_range + T_vehicle_lidar_.translation().norm();
  const double longest = std::sqrt(8 * options_.tolerance / (turn * (turn * reach + speed)));
  const double wanted = std::ceil((static_cast<double>(end) - begin) * 1e-9 / longest);
  const double room = static_cast<double>(options_.max_cells - cells_.size());
  if (!(wanted <= room) || room < 1) return "the motion is too fast to be believed";

  const int64_t count = std::max<int64_t>(1, static_cast<int64_t>(wanted));
  const auto pose_at = [&](int32_t offset) -> Eigen::Matrix4d {
    const double u = to_seconds(origin + Duration(offset) - from.stamp) / seconds;
    const Eigen::Isometry3d T_map_vehicle = from.T_map_vehicle * geometry::exp(u * motion);
    return (T_reference_map * T_map_vehicle * T_vehicle_lidar_).matrix();
  };
  Eigen::Matrix4d start = pose_at(begin);
  int32_t cell_begin = begin;
  const int64_t length = static_cast<int64_t>(end) - begin;
  for (int64_t i = 1; i <= count; ++i) {
    Cell cell;
    cell.begin = cell_begin;
    cell.end = static_cast<int32_t>(begin + length * i / count);
    const Eigen::Matrix4d stop = pose_at(cell.end);
    const int64_t cell_length = static_cast<int64_t>(cell.end) - cell.begin;
    cell.rate = cell_length > 0 ? 1.0f / static_cast<float>(cell_length) : 0.0f;
    cell.start = by_row(start);
    cell.change = by_row(stop - start);
    cells_.push_back(cell);
    start = stop;
    cell_begin = cell.end;
  }
  return "";
}

size_t MotionCompensator::cell_of(int32_t offset, size_t hint) const {
  const Cell& hinted = cells_[hint];
  if (hinted.begin <= offset && offset <= hinted.end) return hint;
  const auto after =
      std::upper_bound(cells_.begin() + 1, cells_.end(), offset,
                       [](int32_t value, const Cell& cell) { return value < cell.begin; });
  return static_cast<size_t>(after - cells_.begin()) - 1;
}

void MotionCompensator::move(const Cell& cell, const Sweep& sweep, size_t from, size_t to,
                             StraightSweep& straight) {
  blend(cell.start.data(), cell.change.data(), cell.begin, cell.rate, &sweep.x[from],
        &sweep.y[from], &sweep.z[from], &sweep.time_offset_ns[from], to - from, &straight.x[from],
        &straight.y[from], &straight.z[from]);
}

void MotionCompensator::apply_cells(const Sweep& sweep, StraightSweep& straight) const {
  const int32_t* offsets = sweep.time_offset_ns.data();
  const size_t count = sweep.size();
  // Returns are in order of time but for the few of one firing, so that most blocks lie in one
  // cell; blocks in a row that share their cell are moved together.
  size_t cell = 0, run = 0;
  for (size_t at = 0; at < count; at += kBlock) {
    const size_t block_end = std::min(count, at + kBlock);
    const Extent times = extent(offsets + at, block_end - at);
    if (cells_[cell].begin <= times.least && times.most <= cells_[cell].end) continue;
    if (run < at) move(cells_[cell], sweep, run, at, straight);
    run = at;
    cell = cell_of(times.least, cell);
    if (times.most <= cells_[cell].end) continue;
    while (run < block_end) {
      cell = cell_of(offsets[run], cell);
      size_t same = run + 1;
      while (same < block_end && cells_[cell].begin <= offsets[same] &&
             offsets[same] <= cells_[cell].end) {
        ++same;
      }
      move(cells_[cell], sweep, run, same, straight);
      run = same;
    }
  }
  if (run < count) move(cells_[cell], sweep, run, count, straight);
}

}  // namespace infuse::motion
