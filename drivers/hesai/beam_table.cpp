#include "drivers/hesai/beam_table.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace infuse::hesai {
namespace {

constexpr size_t kMaxMotorSpeed = 1800;  // rpm; the fastest model turns at 1200
constexpr size_t kSpeeds = kMaxMotorSpeed + 1;
constexpr double kRadiansPerNsAtOneRpm = 2 * std::numbers::pi / 60e9;

}  // namespace

BeamTable::BeamTable(Model model, const Calibration& calibration)
    : info_(&model_info(model)), calibration_(calibration) {
  const size_t loops = number_of_loops(model);
  const auto rings = calibration.rings(*info_);
  for (size_t channel = 0; channel < info_->lasers; ++channel) {
    ring_[channel] = rings[channel];
    sin_elevation_[channel] = static_cast<float>(std::sin(calibration.beams[channel].elevation));
  }
  for (size_t loop = 0; loop < loops; ++loop) {
    firing_[loop] = firing_times(model, loop);
    for (size_t channel = 0; channel < info_->lasers; ++channel) {
      time_ns_[loop][channel] = firing_[loop].channel_ns[channel] - firing_[loop].first_ns;
    }
  }
  filled_.resize(kSpeeds * loops);
  forward_.resize(filled_.size() * info_->lasers);
  right_.resize(forward_.size());
}

BeamTable::Row BeamTable::row(uint16_t motor_speed, size_t loop) {
  const size_t speed = motor_speed > kMaxMotorSpeed ? 0 : motor_speed;
  const size_t row = loop * kSpeeds + speed;
  if (!filled_[row]) {
    fill(row, static_cast<double>(speed) * kRadiansPerNsAtOneRpm, loop);
    filled_[row] = true;
  }
  return {forward_.data() + row * info_->lasers, right_.data() + row * info_->lasers};
}

void BeamTable::fill(size_t row, double turned_per_ns, size_t loop) {
  const FiringTimes& firing = firing_[loop];
  for (size_t channel = 0; channel < info_->lasers; ++channel) {
    const BeamAngles& beam = calibration_.beams[channel];
    const double turned = turned_per_ns * (firing.channel_ns[channel] - firing.azimuth_ns);
    const double horizontal = std::cos(beam.elevation);
    const double azimuth = turned + beam.azimuth_offset;
    const size_t at = row * info_->lasers + channel;
    forward_[at] = static_cast<float>(horizontal * std::cos(azimuth));
    right_[at] = static_cast<float>(horizontal * std::sin(azimuth));
  }
}

}  // namespace infuse::hesai
