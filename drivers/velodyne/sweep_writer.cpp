#include "drivers/velodyne/sweep_writer.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

namespace infuse::velodyne {
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

struct CosSin {
  float cos, sin;
};

/// Cosine and sine of all azimuths, from those of whole degrees and of hundredths.
class AzimuthTable {
 public:
  AzimuthTable() {
    for (size_t i = 0; i < degrees_.size(); ++i) {
      degrees_[i] = std::polar(1.0, static_cast<double>(i) * 100 * kCentidegree);
    }
    for (size_t i = 0; i < hundredths_.size(); ++i) {
      hundredths_[i] = std::polar(1.0, static_cast<double>(i) * kCentidegree);
    }
  }

  CosSin at(uint16_t azimuth) const {
    const Complex& a = degrees_[azimuth / 100];
    const Complex& b = hundredths_[azimuth % 100];
    return {static_cast<float>(a.real() * b.real() - a.imag() * b.imag()),
            static_cast<float>(a.imag() * b.real() + a.real() * b.imag())};
  }

 private:
  using Complex = std::complex<double>;
  std::array<Complex, 360> degrees_;
  std::array<Complex, 100> hundredths_;
};

EchoKinds echo_kinds(const ModelInfo& info, ReturnMode mode) {
  switch (mode) {
    case ReturnMode::kStrongest:
      return {ReturnKind::kStrongest, ReturnKind::kLast};
    case ReturnMode::kLast:
      return {ReturnKind::kLast, ReturnKind::kStrongest};
    case ReturnMode::kDual:
      break;
  }
  return info.calibrated_per_unit ? EchoKinds{ReturnKind::kStrongest, ReturnKind::kLast}
                                  : EchoKinds{ReturnKind::kLast, ReturnKind::kStrongest};
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

void SweepWriter::append(const BeamTable& table, const TimedPacket& timed, const FiringPlan& plan,
                         size_t first, size_t last, bool interpolate) {
  static const AzimuthTable azimuths;
  const ModelInfo& info = *table.info;
  const bool dual = timed.packet.dual();
  const BlockLayout layout = block_layout(info, dual);
  std::array<SequenceBlocks, kBlocks> blocks;
  size_t count = 0;
  for (size_t i = first; i < last; ++i) {
    const PlannedSequence& planned = plan.sequences[i];
    const CosSin azimuth = azimuths.at(planned.azimuth);
    SequenceBlocks& sequence = blocks[count++];
    sequence.returns = timed.bytes.data() + layout.block(i, 0, 0) * kBlockSize + 4;
    sequence.bank_stride = static_cast<uint32_t>(layout.bank * kBlockSize);
    sequence.echo_stride = static_cast<uint32_t>(layout.echo * kBlockSize);
    sequence.cos_azimuth = azimuth.cos;
    sequence.sin_azimuth = azimuth.sin;
    sequence.step = interpolate ? planned.step : uint16_t{0};
    sequence.column = static_cast<uint16_t>(sweep_->columns);
    sequence.time_offset_ns =
        static_cast<int32_t>(timed.device_ns + planned.time_ns - first_device_ns_);
    if (sweep_->columns == 0) {
      first_azimuth_ = planned.azimuth;
    } else {
      turned_ += planned.advance;
    }
    sweep_->columns += info.firings;
  }
  make_room(count * info.slots() * (dual ? 2 : 1));
  const ReturnArrays arrays{sweep_->x.data(),
                            sweep_->y.data(),
                            sweep_->z.data(),
                            sweep_->range.data(),
                            sweep_->reflectivity.data(),
                            sweep_->ring.data(),
                            sweep_->column.data(),
                            sweep_->time_offset_ns.data(),
                            sweep_->return_kind.data()};
  size_ = kernel_(table, std::span(blocks).first(count), echo_kinds(info, timed.packet.mode),
                  arrays, size_);
  last_azimuth_ = plan.sequences[last - 1].azimuth;
  last_step_ = plan.sequences[last - 1].step;
  last_firing_ns_ = blocks[count - 1].time_offset_ns + table.last_firing_ns;
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

void SweepWriter::make_room(size_t returns) {
  const size_t needed = size_ + returns + kKernelSlack;
  if (needed <= sweep_->size()) return;
  sweep_->resize(std::max(needed, sweep_->size() * 2));
}

}  // namespace infuse::velodyne
