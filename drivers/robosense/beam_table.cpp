#include "drivers/robosense/beam_table.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/lidar/azimuth.hpp"

namespace infuse::robosense {
namespace {

constexpr int kMaxTurnsPerSecond = 30;
constexpr size_t kSteps = 128;

// Firing times of the channels, ns: the manuals' appendix on the time of a point. With one return
// four of the lower beams fire in another order than on the wire.

constexpr BeamTable::PerSlot<int32_t> kSingleTimes{
    0,      1'570,  3'150,  4'720,  6'300,  7'870,  9'450,  11'360, 13'260, 15'170, 17'080,
    18'990, 20'560, 22'140, 23'710, 25'290, 26'530, 29'010, 27'770, 30'250, 31'490, 33'980,
    32'730, 35'220, 36'460, 37'700, 38'940, 40'180, 41'420, 42'670, 43'910, 45'150};
constexpr BeamTable::PerSlot<int32_t> kDualTimes{
    0,      1'570,  3'150,  4'720,  6'300,  7'870,  9'450,  11'360, 13'260, 15'170, 17'080,
    18'990, 20'560, 22'140, 23'710, 25'290, 26'530, 27'770, 29'010, 30'250, 31'490, 32'730,
    33'980, 35'220, 36'460, 37'700, 38'940, 40'180, 41'420, 42'670, 43'910, 45'150};
constexpr std::array<int32_t, 16> k16pTimes{0,      3'150,  6'300,  9'450,  13'260, 17'080,
                                            20'560, 23'710, 26'530, 27'770, 31'490, 32'730,
                                            36'460, 38'940, 41'420, 43'910};

/// Number of firings of a channel in one block of one return.
size_t firings_in_block(const ModelInfo& info) { return kChannels / info.lasers; }

int32_t slot_time_ns(const ModelInfo& info, bool dual, size_t slot) {
  const auto channel = static_cast<int32_t>(slot % info.lasers);
  switch (info.model) {
    case Model::kHelios:
      return (dual ? kDualTimes : kSingleTimes)[slot];
    case Model::kHelios16p:
      return k16pTimes[slot % info.lasers] +
             static_cast<int32_t>(slot / info.lasers) * info.period_ns;
    case Model::kBpearl:  // the manual's formula, A.1; the same with two returns
      return 2'560 * (channel % 16) + 1'280 * (channel / 16) + 5'200 * (channel / 8 % 2);
    case Model::kBpearlV4:  // the maker's driver: 1.668 µs each, rounded to 0.01 µs
      return (1'668 * channel + 5) / 10 * 10;
  }
  return 0;
}

}  // namespace

int max_step(const ModelInfo& info) {
  const double block_s = 1e-9 * info.period_ns * static_cast<double>(firings_in_block(info));
  return static_cast<int>(std::ceil(kMaxTurnsPerSecond * lidar::kCentidegreesPerTurn * block_s));
}

BeamTable::BeamTable(Model model, const Calibration& calibration, bool single_origin)
    : info_(&model_info(model)), origin_(single_origin ? 0 : info_->origin_m) {
  for (auto* table : {&forward_, &right_, &origin_forward_, &origin_right_}) {
    table->resize(kSteps * kChannels);
  }
  rebuild(calibration, false);
}

int32_t BeamTable::period_ns() const {
  const bool twice = info_->model == Model::kHelios16p && !dual_;
  return twice ? 2 * info_->period_ns : info_->period_ns;
}

int32_t BeamTable::last_firing_ns() const {
  const bool second = info_->model != Model::kHelios16p || !dual_;
  return *std::max_element(time_ns_.begin(), time_ns_.begin() + (second ? kChannels : 16));
}

void BeamTable::rebuild(const Calibration& calibration, bool dual) {
  calibration_ = calibration;
  dual_ = dual;
  const auto rings = calibration.rings(*info_);
  for (size_t slot = 0; slot < kChannels; ++slot) {
    const size_t channel = slot % info_->lasers;
    const BeamAngles& beam = calibration.beams[channel];
    const double elevation = beam.elevation * lidar::kCentidegree;
    const double horizontal = std::cos(elevation);
    ring_[slot] = rings[channel];
    sin_elevation_[slot] = static_cast<float>(std::sin(elevation));
    time_ns_[slot] = slot_time_ns(*info_, dual, slot);
    const double part = static_cast<double>(time_ns_[slot]) / period_ns();  // of a step
    for (size_t step = 0; step < kSteps; ++step) {
      const double turned = static_cast<double>(step) * part * lidar::kCentidegree;
      const double azimuth = turned + beam.azimuth_offset * lidar::kCentidegree;
      const size_t at = step * kChannels + slot;
      forward_[at] = static_cast<float>(horizontal * std::cos(azimuth));
      right_[at] = side() * static_cast<float>(horizontal * std::sin(azimuth));
      origin_forward_[at] = static_cast<float>(origin_ * std::cos(turned));
      origin_right_[at] = side() * static_cast<float>(origin_ * std::sin(turned));
    }
  }
}

BeamTable::Row BeamTable::row(uint16_t step) const {
  const size_t at = std::min<size_t>(step, kSteps - 1) * kChannels;
  return {forward_.data() + at, right_.data() + at, origin_forward_.data() + at,
          origin_right_.data() + at};
}

}  // namespace infuse::robosense
