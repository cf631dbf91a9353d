#include "drivers/ouster/turn_writer.hpp"

#include <algorithm>
#include <array>
#include <numbers>

#include "drivers/measurement/angles.hpp"

namespace infuse::ouster {
namespace {

constexpr size_t kMaxGaps = 32;
/// Columns without data that are no gap yet.
constexpr int kMaxSkippedColumns = 2;

}  // namespace

TurnWriter::TurnWriter(const Metadata& metadata, const TurnGrid& grid, InstructionSet set)
    : grid_(grid),
      table_(metadata),
      kernel_(return_kernel(metadata.profile, set)),
      first_return_(metadata.first_return),
      echoes_(profile_info(metadata.profile).echoes),
      zero_azimuth_(metadata.begin_azimuth() +
                    2 * std::numbers::pi * grid.index(0) / grid.columns_per_turn()) {}

void TurnWriter::open(Sweep& sweep, int64_t device_ns, Stamp stamp) {
  sweep.clear();
  sweep.gaps.reserve(kMaxGaps + 1);
  sweep.rings = table_.rings;
  sweep.columns = static_cast<uint32_t>(grid_.columns_per_sweep());
  sweep.stamp = stamp;
  sweep.resize(sweep.x.capacity());
  sweep_ = &sweep;
  size_ = 0;
  first_device_ns_ = last_device_ns_ = device_ns;
  first_index_ = next_index_ = -1;
}

void TurnWriter::append(std::span<const Column> columns) {
  std::array<ColumnPixels, kMaxColumnsPerPacket> pixels;
  size_t count = 0;
  for (const Column& column : columns) {
    if (!column.valid) continue;
    const int index = grid_.index(column.measurement_id);
    note_column(index);
    pixels[count++] = {column.pixels, column.measurement_id, static_cast<uint16_t>(index),
                       static_cast<int32_t>(column.device_ns - first_device_ns_)};
    last_device_ns_ = column.device_ns;
  }
  const size_t room = size_ + count * table_.beams * echoes_ + lidar::kReturnSlack;
  if (room > sweep_->size()) sweep_->resize(std::max(room, sweep_->size() * 2));
  const lidar::ReturnArrays arrays{sweep_->x.data(),
                                   sweep_->y.data(),
                                   sweep_->z.data(),
                                   sweep_->range.data(),
                                   sweep_->reflectivity.data(),
                                   sweep_->ring.data(),
                                   sweep_->column.data(),
                                   sweep_->time_offset_ns.data(),
                                   sweep_->return_kind.data()};
  size_ = kernel_(table_, std::span(pixels).first(count), first_return_, arrays, size_);
}

void TurnWriter::close(const ClockState& clock, uint64_t sequence) {
  add_gap(next_index_, first_index_ + grid_.columns_per_turn());
  sweep_->resize(size_);
  sweep_->span = Duration(last_device_ns_ - first_device_ns_);
  sweep_->clock = clock;
  sweep_->sequence = sequence;
  sweep_ = nullptr;
}

void TurnWriter::note_column(int index) {
  if (first_index_ < 0) {
    first_index_ = index;
  } else {
    add_gap(next_index_, index);
  }
  next_index_ = index + 1;
  sweep_->columns = std::max(sweep_->columns, static_cast<uint32_t>(next_index_));
}

/// Adds a gap at the indices `from` … `to` − 1, if there is one.
void TurnWriter::add_gap(int from, int to) {
  if (to - from <= kMaxSkippedColumns) return;
  if (sweep_->gaps.size() < kMaxGaps) {
    sweep_->gaps.push_back({azimuth(from), azimuth(to)});
  } else {
    sweep_->gaps.back().to = azimuth(to);
  }
}

double TurnWriter::azimuth(int index) const {
  return wrap_angle(zero_azimuth_ - 2 * std::numbers::pi * index / grid_.columns_per_turn());
}

}  // namespace infuse::ouster
