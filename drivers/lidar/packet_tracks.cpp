#include "drivers/lidar/packet_tracks.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/lidar/arrival_order.hpp"
#include "drivers/lidar/azimuth.hpp"

namespace infuse::lidar {
namespace {

constexpr int64_t kMaxStepUs = 100'000;      // longer silence: the track begins anew
constexpr int64_t kMaxReorderUs = 5'000;     // late packets within this belong to their track
constexpr double kMaxRate = 36'000 * 30e-6;  // 0.01° per µs: thirty turns per second
constexpr double kAzimuthTolerance = 300;    // 0.01°, between predicted and stated azimuth
constexpr double kRelativeTolerance = 0.02;  // of the turned angle, for changes of the rate
constexpr uint64_t kEstablished = 4;         // packets that make a track more than a stray packet

}  // namespace

std::optional<PacketTracks::Step> PacketTracks::step_from(const Track& track, Duration counter,
                                                          int azimuth) const {
  const int64_t period_us = counter_difference(counter, track.counter, modulo_).count() / 1000;
  if (period_us <= -kMaxReorderUs || period_us > kMaxStepUs) return std::nullopt;
  const double most = kMaxRate * static_cast<double>(std::abs(period_us)) + kAzimuthTolerance;
  const int advance = azimuth_advance(track.azimuth, azimuth);
  if (track.count < 2) {
    if (period_us <= 0 || advance > most) return std::nullopt;
    return Step{period_us, advance};
  }
  const double turned = track.rate * static_cast<double>(period_us);
  const double error = std::remainder(advance - turned, kCentidegreesPerTurn);
  if (std::abs(error) > kAzimuthTolerance + kRelativeTolerance * std::abs(turned))
    return std::nullopt;
  return Step{period_us, static_cast<int>(std::lround(turned + error))};
}

void PacketTracks::extend(Track& track, const Step& step, Duration counter, int azimuth) {
  constexpr double kGain = 0.2;
  const double rate = static_cast<double>(step.advance) / static_cast<double>(step.period_us);
  track.rate = track.count < 2 ? rate : track.rate + kGain * (rate - track.rate);
  track.counter = counter;
  track.azimuth = azimuth;
}

PacketTracks::Step PacketTracks::add(Duration counter, int azimuth) {
  ++packets_;
  for (size_t i = 0; i < tracks_.size(); ++i) {
    const size_t index = (current_ + i) % tracks_.size();
    Track& track = tracks_[index];
    if (track.count == 0) continue;
    const auto step = step_from(track, counter, azimuth);
    if (!step) continue;
    if (index != current_ && track.count >= kEstablished &&
        tracks_[current_].count >= kEstablished) {
      ++alternations_;
    }
    current_ = index;
    track.latest = packets_;
    if (step->period_us <= 0) return {};  // late or repeated
    extend(track, *step, counter, azimuth);
    ++track.count;
    return *step;
  }
  auto* oldest = std::min_element(tracks_.begin(), tracks_.end(),
                                  [](const auto& a, const auto& b) { return a.latest < b.latest; });
  *oldest = {counter, azimuth, 0, 1, packets_};
  current_ = static_cast<size_t>(oldest - tracks_.begin());
  return {};
}

}  // namespace infuse::lidar
