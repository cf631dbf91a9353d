#include "drivers/velodyne/sweep_cutter.hpp"

#include <cstdlib>

namespace infuse::velodyne {

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

}  // namespace infuse::velodyne
