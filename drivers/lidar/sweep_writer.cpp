#include "drivers/lidar/sweep_writer.hpp"

#include <algorithm>

#include "drivers/lidar/azimuth.hpp"

namespace infuse::lidar {
namespace {

constexpr size_t kMaxGaps = 32;
constexpr uint32_t kMaxColumns = 65'000;

/// Converts the sensor's azimuth (0.01°, clockwise) to the lidar frame's (rad, counter-clockwise,
/// −π … π).
double lidar_azimuth(int azimuth) {
  const int turned = (azimuth % kCentidegreesPerTurn + kCentidegreesPerTurn) % kCentidegreesPerTurn;
  return -kCentidegree *
         (turned > kCentidegreesPerTurn / 2 ? turned - kCentidegreesPerTurn : turned);
}

}  // namespace

void SweepWriter::open(Sweep& sweep, uint16_t rings, int64_t device_ns, Stamp stamp) {
  sweep.clear();
  sweep.gaps.reserve(kMaxGaps + 1);
  sweep.rings = rings;
  sweep.stamp = stamp;
  sweep.resize(sweep.x.capacity());
  sweep_ = &sweep;
  size_ = 0;
  first_device_ns_ = device_ns;
  last_firing_ns_ = 0;
  turned_ = 0;
}

bool SweepWriter::accepts(int64_t device_ns, Duration max_span) const {
  const int64_t span = device_ns - first_device_ns_;
  return span >= 0 && span < max_span.count() && sweep_->columns < kMaxColumns;
}

void SweepWriter::add_gap(int from, int to) {
  if (sweep_->gaps.size() < kMaxGaps) {
    sweep_->gaps.push_back({lidar_azimuth(from), lidar_azimuth(to)});
  } else {
    sweep_->gaps.back().to = lidar_azimuth(to);
  }
}

void SweepWriter::close(const ClockState& clock, uint64_t sequence) {
  const int end = last_azimuth_ + last_step_;
  if (turned_ + last_step_ < kCentidegreesPerTurn - 2 * std::max(last_step_, 1)) {
    sweep_->gaps.push_back({lidar_azimuth(end), lidar_azimuth(first_azimuth_)});
  }
  sweep_->resize(size_);
  sweep_->span = Duration(last_firing_ns_);
  sweep_->clock = clock;
  sweep_->sequence = sequence;
  sweep_ = nullptr;
}

ReturnArrays SweepWriter::make_room(size_t returns) {
  const size_t needed = size_ + returns + kReturnSlack;
  if (needed > sweep_->size()) sweep_->resize(std::max(needed, sweep_->size() * 2));
  return {sweep_->x.data(),
          sweep_->y.data(),
          sweep_->z.data(),
          sweep_->range.data(),
          sweep_->reflectivity.data(),
          sweep_->ring.data(),
          sweep_->column.data(),
          sweep_->time_offset_ns.data(),
          sweep_->return_kind.data()};
}

}  // namespace infuse::lidar
