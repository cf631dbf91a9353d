#include "fusion/motion/deskew.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/measurement/simd.hpp"

namespace infuse::motion {
namespace {

using geometry::Trajectory;
using geometry::Vector6;

constexpr size_t kBlockSize = 64;  // returns whose cells are in the first-level cache together

struct TimeRange {
  int32_t min, max;
};

INFUSE_SIMD_CLONES
TimeRange find_time_range(const int32_t* offsets, size_t count) {
  int32_t min = offsets[0], max = offsets[0];
  for (size_t i = 0; i < count; ++i) {
    min = offsets[i] < min ? offsets[i] : min;
    max = offsets[i] > max ? offsets[i] : max;
  }
  return {min, max};
}

INFUSE_SIMD_CLONES
void transform_returns(const float* start, const float* change, int32_t begin, float rate,
                       const float* __restrict x, const float* __restrict y,
                       const float* __restrict z, const int32_t* __restrict offset, size_t count,
                       float* __restrict out_x, float* __restrict out_y, float* __restrict out_z) {
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

std::array<float, 12> to_row_major(const Eigen::Matrix4d& m) {
  std::array<float, 12> rows{};
  for (int i = 0; i < 12; ++i) rows[static_cast<size_t>(i)] = static_cast<float>(m(i / 4, i % 4));
  return rows;
}

}  // namespace

std::optional<std::string> DeskewOptions::invalid() const {
  if (!(tolerance > 0) || !(max_range > 0)) return "tolerance and max_range must be positive";
  if (max_cells < 1) return "max_cells must be at least 1";
  return std::nullopt;
}

Deskewer::Deskewer(const Eigen::Isometry3d& T_vehicle_lidar, const DeskewOptions& options)
    : T_vehicle_lidar_(T_vehicle_lidar), options_(options) {
  cells_.reserve(options.max_cells);
}

void Deskewer::deskew(const Sweep& sweep, const Trajectory& trajectory, Stamp reference,
                      DeskewedSweep& deskewed) {
  deskewed.reference = reference;
  deskewed.motion = {};
  deskewed.reason = "";
  deskewed.x.resize(sweep.size());
  deskewed.y.resize(sweep.size());
  deskewed.z.resize(sweep.size());
  if (sweep.size() == 0) return;

  if (!sweep.has_times) {
    deskewed.reason = "the sweep has no time for each return";
  } else {
    const TimeRange times = find_time_range(sweep.time_offset_ns.data(), sweep.size());
    const Stamp first = sweep.stamp + Duration(times.min);
    const Stamp last = sweep.stamp + Duration(times.max);
    const bool done = sweep.deskewed && first == reference && last == reference;
    deskewed.reason =
        done ? ""
             : trajectory.uncovered_reason(std::min(first, reference), std::max(last, reference));
    if (done) {
      deskewed.x = sweep.x;
      deskewed.y = sweep.y;
      deskewed.z = sweep.z;
      return;
    }
    if (deskewed.usable()) {
      deskewed.motion = trajectory.between(first, last);
      const Eigen::Isometry3d T_reference_odom =
          (trajectory.at(reference).T_odom_vehicle * T_vehicle_lidar_).inverse();
      deskewed.reason = build_cells(sweep, trajectory, T_reference_odom, times.min, times.max);
    }
  }
  if (deskewed.usable()) {
    apply_cells(sweep, deskewed);
  } else {
    std::copy(sweep.x.begin(), sweep.x.end(), deskewed.x.begin());
    std::copy(sweep.y.begin(), sweep.y.end(), deskewed.y.begin());
    std::copy(sweep.z.begin(), sweep.z.end(), deskewed.z.begin());
  }
}

const char* Deskewer::build_cells(const Sweep& sweep, const Trajectory& trajectory,
                                  const Eigen::Isometry3d& T_reference_odom, int32_t first,
                                  int32_t last) {
  cells_.clear();
  const Stamp origin = sweep.stamp;
  if (trajectory.size() < 2) return "the trajectory has fewer than two poses";
  // The segment of the first return; times past the last pose belong to the last segment.
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
      const char* reason =
          add_cells(trajectory[next - 1], to, T_reference_odom, origin, begin, end);
      if (*reason != '\0') return reason;
      begin = end;
    }
    ++next;
  } while (begin < last && next < trajectory.size());
  return "";
}

const char* Deskewer::add_cells(const geometry::StampedPose& from, const geometry::StampedPose& to,
                                const Eigen::Isometry3d& T_reference_odom, Stamp origin,
                                int32_t begin, int32_t end) {
  const double seconds = to_seconds(to.stamp - from.stamp);
  const Vector6 motion = geometry::log(from.T_odom_vehicle.inverse() * to.T_odom_vehicle);
  const double angular_speed = motion.head<3>().norm() / seconds;
  const double speed = motion.tail<3>().norm() / seconds;
  const double max_radius = options_.max_range + T_vehicle_lidar_.translation().norm();
  const double max_cell_seconds =
      std::sqrt(8 * options_.tolerance / (angular_speed * (angular_speed * max_radius + speed)));
  const double cells_needed =
      std::ceil((static_cast<double>(end) - begin) * 1e-9 / max_cell_seconds);
  const double cells_left = static_cast<double>(options_.max_cells - cells_.size());
  if (!(cells_needed <= cells_left) || cells_left < 1) return "the motion is too fast to deskew";

  const int64_t count = std::max<int64_t>(1, static_cast<int64_t>(cells_needed));
  const auto pose_at = [&](int32_t offset) -> Eigen::Matrix4d {
    const double u = to_seconds(origin + Duration(offset) - from.stamp) / seconds;
    const Eigen::Isometry3d T_map_vehicle = from.T_odom_vehicle * geometry::exp(u * motion);
    return (T_reference_odom * T_map_vehicle * T_vehicle_lidar_).matrix();
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
    cell.start = to_row_major(start);
    cell.change = to_row_major(stop - start);
    cells_.push_back(cell);
    start = stop;
    cell_begin = cell.end;
  }
  return "";
}

size_t Deskewer::find_cell(int32_t offset, size_t hint) const {
  const Cell& hinted = cells_[hint];
  if (hinted.begin <= offset && offset <= hinted.end) return hint;
  const auto after =
      std::upper_bound(cells_.begin() + 1, cells_.end(), offset,
                       [](int32_t value, const Cell& cell) { return value < cell.begin; });
  return static_cast<size_t>(after - cells_.begin()) - 1;
}

void Deskewer::transform(const Cell& cell, const Sweep& sweep, size_t from, size_t to,
                         DeskewedSweep& deskewed) {
  transform_returns(cell.start.data(), cell.change.data(), cell.begin, cell.rate, &sweep.x[from],
                    &sweep.y[from], &sweep.z[from], &sweep.time_offset_ns[from], to - from,
                    &deskewed.x[from], &deskewed.y[from], &deskewed.z[from]);
}

void Deskewer::apply_cells(const Sweep& sweep, DeskewedSweep& deskewed) const {
  const int32_t* offsets = sweep.time_offset_ns.data();
  const size_t count = sweep.size();
  // Returns are in time order except within one firing, so most blocks lie in one cell; consecutive
  // blocks of the same cell are transformed together.
  size_t cell = 0, run = 0;
  for (size_t at = 0; at < count; at += kBlockSize) {
    const size_t block_end = std::min(count, at + kBlockSize);
    const TimeRange times = find_time_range(offsets + at, block_end - at);
    if (cells_[cell].begin <= times.min && times.max <= cells_[cell].end) continue;
    if (run < at) transform(cells_[cell], sweep, run, at, deskewed);
    run = at;
    cell = find_cell(times.min, cell);
    if (times.max <= cells_[cell].end) continue;
    while (run < block_end) {
      cell = find_cell(offsets[run], cell);
      size_t same = run + 1;
      while (same < block_end && cells_[cell].begin <= offsets[same] &&
             offsets[same] <= cells_[cell].end) {
        ++same;
      }
      transform(cells_[cell], sweep, run, same, deskewed);
      run = same;
    }
  }
  if (run < count) transform(cells_[cell], sweep, run, count, deskewed);
}

}  // namespace infuse::motion
