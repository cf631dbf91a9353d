#include "fusion/watch/drift_test.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace infuse::watch {
namespace {

constexpr int kBlock = 4;                  // looks whose mean is compared with the next four's
constexpr double kMemory = 1.0 / 30;       // looks after which the mean offset fades
constexpr double kNoiseMemory = 1.0 / 60;  // blocks
constexpr double kPriorBlocks = 2;         // what is taken for granted counts as so many
constexpr double kPriorNoise = 0.006;      // κ: from simulated streets, with a third to spare
constexpr double kOutlier = 9;  // a block's κ counts at most so many times the mean so far
/// What a look counts: the looks of one street share what misleads them, for longer than a block.
constexpr double kAlike = 0.7;

/// Looked at with steps that stay on the top's flanks.
bool near(size_t axis) { return axis <= static_cast<size_t>(Axis::kY); }

}  // namespace

std::optional<std::string> DriftTestOptions::invalid() const {
  for (size_t k = 0; k < kAxes; ++k) {
    if (!(kept[k] >= 0) || !(drifted[k] > kept[k])) return "0 <= kept < drifted must hold";
  }
  if (!(false_alarm_hours > 0) || !(looks_per_second > 0)) {
    return "false_alarm_hours and looks_per_second must be positive";
  }
  if (!(suspect > 0) || suspect >= certain()) return "suspect must be less than what is certain";
  if (!(most_a_look > 0)) return "most_a_look must be positive";
  if (warm_up < 2 * kBlock) return "warm_up must be at least 8";
  return std::nullopt;
}

double AxisLook::information(size_t axis) const {
  const double least = step[axis] > 0 ? std::abs(slope[axis]) / step[axis] : 0;
  return std::max(bend[axis], least);
}

double AxisLook::offset(size_t axis) const {
  const double worth = information(axis);
  return worth > 0 ? slope[axis] / worth : 0;
}

double DriftTestOptions::certain() const {
  return std::log(2.0 * kAxes * false_alarm_hours * 3600 * looks_per_second);
}

DriftTest::DriftTest(const DriftTestOptions& options)
    : options_(options), certain_(options.certain()) {}

double DriftTest::noise_of(const Track& track) const {
  return (track.noise + kPriorBlocks * kPriorNoise) / (track.noises + kPriorBlocks);
}

void DriftTest::learn_noise(Track& track, double offset, double information) {
  track.block += information * offset;
  track.block_weight += information;
  if ((looks_ + 1) % kBlock != 0) return;
  if (track.last_weight > 0 && track.block_weight > 0) {
    // Var(a − b) = κ (1/wa + 1/wb), of blocks that are nearly independent.
    const double apart = track.block / track.block_weight - track.last / track.last_weight;
    const double shared = 1 / track.block_weight + 1 / track.last_weight;
    const double noise = std::min(apart * apart / shared, kOutlier * noise_of(track));
    track.noise += noise - kNoiseMemory * track.noise;
    track.noises += 1 - kNoiseMemory * track.noises;
  }
  track.last = track.block;
  track.last_weight = track.block_weight;
  track.block = track.block_weight = 0;
}

void DriftTest::Mean::add(double slope, double information) {
  sum += slope - kMemory * sum;
  weight += information - kMemory * weight;
}

void DriftTest::add(const AxisLook& look) {
  for (size_t k = 0; k < kAxes; ++k) {
    Track& track = tracks_[k];
    const double w = look.information(k);
    learn_noise(track, look.offset(k), w);
    track.all.add(look.slope[k], w);
    const double gap = options_.drifted[k] - options_.kept[k];
    const double middle = 0.5 * (options_.drifted[k] + options_.kept[k]);
    const double scale = kAlike * gap / noise_of(track);
    const double bend = near(k) ? look.bend[k] : w;
    const auto step = [&](Run& run, double sign) {
      const double ratio = scale * (sign * look.slope[k] - middle * bend);
      run.evidence += std::clamp(ratio, -options_.most_a_look, options_.most_a_look);
      run.mean.add(look.slope[k], w);
      if (run.evidence <= 0) run = {};
    };
    step(track.up, 1);
    step(track.down, -1);
  }
  ++looks_;
}

void DriftTest::restart() {
  for (Track& track : tracks_) {
    track.up = track.down = {};
    track.all = {};
    track.block = track.block_weight = track.last = track.last_weight = 0;
  }
}

double DriftTest::evidence(Axis axis) const {
  const Track& track = tracks_[static_cast<size_t>(axis)];
  return std::max(track.up.evidence, track.down.evidence);
}

Axis DriftTest::strongest() const {
  Axis best = Axis::kRotationX;
  for (size_t k = 1; k < kAxes; ++k) {
    if (evidence(static_cast<Axis>(k)) > evidence(best)) best = static_cast<Axis>(k);
  }
  return best;
}

Axis DriftTest::stronger_look(Axis axis) const {
  Axis best = axis;
  for (size_t k = 0; k < kAxes; ++k) {
    const auto other = static_cast<Axis>(k);
    if (near_axis(other) == axis && evidence(other) > evidence(best)) best = other;
  }
  return best;
}

const DriftTest::Mean& DriftTest::telling_mean(const Track& track) const {
  const Run& stronger = track.up.evidence > track.down.evidence ? track.up : track.down;
  return stronger.evidence >= options_.suspect ? stronger.mean : track.all;
}

double DriftTest::offset(Axis axis) const {
  const Mean& mean = telling_mean(tracks_[static_cast<size_t>(axis)]);
  return mean.weight > 0 ? mean.sum / mean.weight : 0;
}

double DriftTest::deviation(Axis axis) const {
  const Track& track = tracks_[static_cast<size_t>(axis)];
  const Mean& mean = telling_mean(track);
  return mean.weight > 0 ? std::sqrt(noise_of(track) / mean.weight)
                         : std::numeric_limits<double>::infinity();
}

const char* to_string(Axis axis) {
  constexpr std::array<const char*, 7> kNames = {"rotation about x",
                                                 "rotation about y",
                                                 "rotation about z",
                                                 "translation along x",
                                                 "translation along y",
                                                 "translation along z",
                                                 "time"};
  return kNames[static_cast<size_t>(near_axis(axis))];
}

}  // namespace infuse::watch
