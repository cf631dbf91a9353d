#include "drivers/import/ring_cuts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "drivers/measurement/fast_atan2.hpp"
#include "drivers/recording/sweep_files.hpp"

namespace infuse::importers {
namespace {

constexpr size_t kMaxSweeps = 50;
constexpr double kRotorStep = 0.09;      // deg
constexpr double kStepTolerance = 0.02;  // deg
constexpr int kPositions = 4000;         // of the rotor
constexpr int kMaxShift = 225;           // rotor steps, 20 deg
constexpr int kPeakWidth = 4;            // rotor steps
constexpr double kClear = 4;             // standard deviations of a count

// For each ring, the numbers of rotor positions at which a single step was reported.
using SingleSteps = std::vector<std::vector<int>>;

// For each shift from −kMaxShift, how many single steps of a ring meet one of the reference.
using Matches = std::array<double, 2 * kMaxShift + 1>;

SingleSteps find_single_steps(const Sweep& sweep) {
  SingleSteps steps(sweep.rings);
  const auto azimuth_deg = [&](size_t i) {
    return fast_atan2(static_cast<double>(sweep.y[i]), static_cast<double>(sweep.x[i])) * 180 /
           std::numbers::pi;
  };
  double last = 0;
  for (size_t i = 0; i < sweep.size(); ++i) {
    const double azimuth = azimuth_deg(i);
    const bool same_ring = i > 0 && sweep.ring[i] == sweep.ring[i - 1];
    if (same_ring && std::abs(azimuth - last - kRotorStep) < kStepTolerance) {
      const double middle = (azimuth + last) / 2 + 360;
      steps[sweep.ring[i]].push_back(static_cast<int>(middle / kRotorStep) % kPositions);
    }
    last = azimuth;
  }
  return steps;
}

// Adds to each ring's `matches` those with the steps of the reference, less what chance would give.
void add_matches(const SingleSteps& steps, size_t reference, std::vector<Matches>& matches) {
  std::array<double, kPositions> is_step{};
  for (const int position : steps[reference]) {
    for (int near = position - 1; near <= position + 1; ++near)
      is_step[static_cast<size_t>((near + kPositions) % kPositions)] = 1;
  }
  const double chance = std::accumulate(is_step.begin(), is_step.end(), 0.0) / kPositions;
  for (size_t ring = 0; ring < steps.size(); ++ring) {
    for (const int position : steps[ring]) {
      for (int shift = -kMaxShift; shift <= kMaxShift; ++shift) {
        const auto met = static_cast<size_t>((position + shift + kPositions) % kPositions);
        matches[ring][static_cast<size_t>(shift + kMaxShift)] += is_step[met] - chance;
      }
    }
  }
}

// Azimuth of a ring minus that of the reference in degrees; not a number if several shifts match
// nearly as well.
double find_offset_deg(const Matches& matches) {
  const auto best = std::max_element(matches.begin(), matches.end());
  double second = 0;
  for (auto other = matches.begin(); other != matches.end(); ++other) {
    if (std::abs(other - best) > kPeakWidth) second = std::max(second, *other);
  }
  if (!(*best - second > kClear * std::sqrt(*best))) return std::nan("");
  return -kRotorStep * static_cast<double>(best - matches.begin() - kMaxShift);
}

size_t fullest(const SingleSteps& steps) {
  const auto best = std::max_element(
      steps.begin(), steps.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return static_cast<size_t>(best - steps.begin());
}

// Sweeps with the most frequent number of rings.
std::vector<SingleSteps> read_single_steps(const std::vector<StampedFile>& sweeps) {
  const size_t stride = sweeps.size() / kMaxSweeps + 1;
  std::vector<SingleSteps> all;
  std::map<size_t, size_t> sweeps_with;
  Sweep sweep;
  recording::SweepReader reader;
  for (size_t k = 0; k < sweeps.size(); k += stride) {
    if (!reader.read(sweeps[k].path, sweep) || sweep.rings == 0) continue;
    all.push_back(find_single_steps(sweep));
    ++sweeps_with[sweep.rings];
  }
  const auto usual =
      std::max_element(sweeps_with.begin(), sweeps_with.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  std::erase_if(all, [&](const SingleSteps& steps) { return steps.size() != usual->first; });
  return all;
}

}  // namespace

std::vector<double> find_ring_cuts(const std::vector<StampedFile>& sweeps, double cut_deg) {
  const std::vector<SingleSteps> all = read_single_steps(sweeps);
  if (all.empty()) return {};
  const size_t reference = fullest(all.front());
  std::vector<Matches> matches(all.front().size());
  for (const SingleSteps& steps : all) add_matches(steps, reference, matches);
  std::vector<double> offsets;
  double sum = 0;
  size_t clear = 0;
  for (const Matches& of_ring : matches) {
    offsets.push_back(find_offset_deg(of_ring));
    if (std::isnan(offsets.back())) continue;
    sum += offsets.back();
    ++clear;
  }
  if (clear * 4 < offsets.size() * 3) return {};
  const double mean = sum / static_cast<double>(clear);
  for (double& offset : offsets)
    offset = cut_deg + (std::isnan(offset) ? 0 : std::round((offset - mean) * 100) / 100);
  return offsets;
}

}  // namespace infuse::importers
