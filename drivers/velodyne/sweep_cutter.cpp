#include "drivers/velodyne/sweep_cutter.hpp"

#include <cstdlib>

namespace infuse::velodyne {

bool SweepCutter::cuts_before(int azimuth, int64_t advance, bool after_jump) {
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
  if (since_jump_ > kTurn) partial_turn_ = false;
  to_cut_ -= advance;
  if (to_cut_ > 0) return false;
  to_cut_ = kTurn - (-to_cut_) % kTurn;
  return !partial_turn_;
}

bool SweepCutter::is_known_jump(int from, int to) const {
  constexpr int kTolerance = 200;  // 0.01°
  const auto near = [](int a, int b) {
    const int apart = (a - b + 2 * kTurn) % kTurn;
    return apart < kTolerance || apart > kTurn - kTolerance;
  };
  return partial_turn_ && near(from, jump_from_) && near(to, jump_to_);
}

void SweepCutter::start(int azimuth) {
  started_ = true;
  since_jump_ = 0;
  to_cut_ = kTurn - (azimuth - cut_azimuth_ + kTurn) % kTurn;
}

}  // namespace infuse::velodyne
