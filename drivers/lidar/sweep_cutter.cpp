#include "drivers/lidar/sweep_cutter.hpp"

#include <cmath>
#include <cstdlib>

namespace infuse::lidar {

bool SweepCutter::process_sequence(int azimuth, int64_t advance, bool after_jump) {
  const int before = azimuth_;
  azimuth_ = azimuth;
  if (!started_) {
    start(azimuth);
    return true;
  }
  if (after_jump) {
    partial_turn_ = true;
    jump_from_ = before;
    jump_to_ = azimuth;
    start(azimuth);
    return true;
  }
  since_jump_ += advance;
  if (since_jump_ > kCentidegreesPerTurn) partial_turn_ = false;
  to_cut_ -= advance;
  if (to_cut_ > 0) return false;
  to_cut_ = kCentidegreesPerTurn - (-to_cut_) % kCentidegreesPerTurn;
  return !partial_turn_;
}

bool SweepCutter::process_lossy_jump(int azimuth) {
  azimuth_ = azimuth;
  start(azimuth);
  return true;
}

void SweepCutter::process_packet(const FiringPlan& plan, bool lossy_jump,
                                 std::array<bool, kMaxSequences>& begins) {
  for (size_t i = 0; i < plan.count; ++i) {
    const PlannedSequence& sequence = plan.sequences[i];
    begins[i] = i == 0 && lossy_jump
                    ? process_lossy_jump(sequence.azimuth)
                    : process_sequence(sequence.azimuth, sequence.advance, sequence.after_jump);
  }
}

int64_t SweepCutter::pause_within(int from, int64_t gap_ns, int64_t period_ns,
                                  const RotationRate& rotation) const {
  constexpr double kTolerance = 200;  // 0.01°
  if (!partial_turn_) return 0;
  const double rate = rotation.per_ns();
  if (rate <= 0) return 0;
  const double turned = rate * static_cast<double>(gap_ns + period_ns);
  const int width = (jump_to_ - jump_from_ + kCentidegreesPerTurn) % kCentidegreesPerTurn;
  const double beyond = turned - azimuth_advance(from, jump_from_) - width + kTolerance;
  const double passes = std::floor(beyond / kCentidegreesPerTurn) + 1;
  if (passes < 1) return 0;
  return static_cast<int64_t>(passes * (width / rate - static_cast<double>(period_ns)));
}

bool SweepCutter::is_known_jump(int from, int to) const {
  constexpr int kTolerance = 200;  // 0.01°
  const auto near = [](int a, int b) {
    const int apart = (a - b + 2 * kCentidegreesPerTurn) % kCentidegreesPerTurn;
    return apart < kTolerance || apart > kCentidegreesPerTurn - kTolerance;
  };
  return partial_turn_ && near(from, jump_from_) && near(to, jump_to_);
}

void SweepCutter::start(int azimuth) {
  started_ = true;
  since_jump_ = 0;
  to_cut_ =
      kCentidegreesPerTurn - (azimuth - cut_azimuth_ + kCentidegreesPerTurn) % kCentidegreesPerTurn;
}

}  // namespace infuse::lidar
