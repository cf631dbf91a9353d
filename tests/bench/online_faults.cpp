// Faults of a calibration that slip, jump or shift in time on simulated drives: when the monitor
// suspects and confirms them, and what it says of them.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>

#include "drivers/measurement/angles.hpp"
#include "tests/bench/online_loop.hpp"
#include "tests/bench/online_scenarios.hpp"

namespace infuse::online {
namespace {

/// Accumulated angle of a drift of 0.05° per minute when it is suspected and when it is confirmed:
/// the worst of three axes and both signs.
void slow_drift(benchmark::State& state) {
  double suspected = 0, confirmed = 0;
  for (auto _ : state) {
    std::vector<const Drive*> drives;
    for (int round = 0; round < 2; ++round) {
      for (const std::string& name : kScenarios) drives.push_back(&load_drive(name));
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (const double rate : {0.05, -0.05}) {
        const DriftAngles detected = detect_slow_drift(drives, axis, rate);
        std::fprintf(stderr,
                     "axis %d, %+.2f degrees a minute: suspected at %.3f, confirmed at %.3f\n",
                     axis, rate, detected.suspected_deg, detected.confirmed_deg);
        suspected = std::max(suspected, detected.suspected_deg);
        confirmed = std::max(confirmed, detected.confirmed_deg);
      }
    }
    state.SetIterationTime(1);
  }
  state.counters["suspected_worst_deg"] = std::min(suspected, 9.0);
  state.counters["confirmed_worst_deg"] = std::min(confirmed, 9.0);
}

/// Knocks about or along every axis in every condition, `size` in degrees or cm, in both
/// directions: time to suspicion and confirmation, and how many are named with their axis and have
/// an amount within three stated standard deviations.
void knocks(benchmark::State& state, const std::vector<int>& axes, double size) {
  std::vector<double> suspected, confirmed;
  double named = 0, covered = 0;
  for (auto _ : state) {
    for (size_t k = 0; k < kScenarios.size() * axes.size() * 2; ++k) {
      const Drive& drive = load_drive(kScenarios[k % kScenarios.size()]);
      const int axis = axes[k / kScenarios.size() / 2];
      const double sign = k / kScenarios.size() % 2 == 0 ? 1 : -1;
      const double amount = sign * size * (axis < 3 ? kDegree : 0.01);
      const Fault fault{amount * Vector6::Unit(axis), 30 + 7 * k % 60};
      const KnockResult found = run_knock(drive, fault);
      const auto& verdict = found.verdict;
      suspected.push_back(found.suspected);
      confirmed.push_back(found.confirmed);
      const bool right = verdict.axis == static_cast<monitoring::Axis>(axis);
      const bool inside = std::abs(verdict.offset(axis) - amount) <= 3 * verdict.sigma(axis);
      named += right ? 1 : 0;
      covered += inside ? 1 : 0;
      if (right && inside && found.confirmed < kNotDetected) continue;
      std::fprintf(stderr,
                   "%s, pair %zu, axis %d by %+.1f: suspected %.1f s, confirmed %.1f s: %s\n",
                   kScenarios[k % kScenarios.size()].c_str(), fault.first_pair, axis, sign * size,
                   found.suspected, found.confirmed, describe_drift(verdict).c_str());
    }
    state.SetIterationTime(std::min(quantile(confirmed, 0.5), 600.0));
  }
  const auto all = static_cast<double>(confirmed.size());
  state.counters["suspected_median_s"] = std::min(quantile(suspected, 0.5), 600.0);
  state.counters["suspected_p95_s"] = std::min(quantile(suspected, 0.95), 600.0);
  state.counters["confirmed_p95_s"] = std::min(quantile(confirmed, 0.95), 600.0);
  state.counters["named_percent"] = 100 * named / all;
  state.counters["covered_percent"] = 100 * covered / all;
  state.SetLabel("to confirmation, median");
}

/// Stamps that become late or early by `delay` s: how often they are suspected, and how often named
/// as late stamps or as the axis that this motion cannot tell from them.
void late_stamps(benchmark::State& state, double delay) {
  double suspected = 0, confirmed = 0, named = 0, all = 0;
  for (auto _ : state) {
    for (size_t k = 0; k < 4 * kScenarios.size(); ++k) {
      const Fault fault{Vector6::Zero(), 30 + 7 * k % 60};
      const double late = k / kScenarios.size() % 2 == 0 ? delay : -delay;
      const KnockResult found =
          run_knock(load_drive(kScenarios[k % kScenarios.size()]), fault, late);
      const auto& verdict = found.verdict;
      const bool seen = found.suspected < kNotDetected;
      const bool right =
          verdict.axis == monitoring::Axis::kTime || verdict.delay_ambiguous_axis == verdict.axis;
      ++all;
      suspected += seen ? 1 : 0;
      confirmed += found.confirmed < kNotDetected ? 1 : 0;
      named += seen && right ? 1 : 0;
      std::fprintf(stderr, "%+.0f ms: suspected %.1f s, confirmed %.1f s: %s\n", 1e3 * late,
                   found.suspected, found.confirmed, describe_drift(verdict).c_str());
    }
    state.SetIterationTime(1);
  }
  state.counters["faults"] = all;
  state.counters["suspected"] = suspected;
  state.counters["confirmed"] = confirmed;
  state.counters["named"] = named;
}

const int kFaultsRegistered = [] {
  for (const double degrees : {0.5, 1.0, 2.0, 3.0, 5.0}) {
    char name[48];
    std::snprintf(name, sizeof name, "online/knocks/%.1f_deg", degrees);
    register_run(name, [=](benchmark::State& state) { knocks(state, {0, 1, 2}, degrees); });
  }
  for (const double ms : {20.0, 50.0, 100.0}) {
    char name[48];
    std::snprintf(name, sizeof name, "online/late_stamps/%.0f_ms", ms);
    register_run(name, [=](benchmark::State& state) { late_stamps(state, 1e-3 * ms); });
  }
  for (const double cm : {10.0, 20.0}) {
    char name[48];
    std::snprintf(name, sizeof name, "online/knocks/%.0f_cm", cm);
    register_run(name, [=](benchmark::State& state) { knocks(state, {3, 4, 5}, cm); });
  }
  register_run("online/slow_drift", slow_drift);
  return 0;
}();

}  // namespace
}  // namespace infuse::online
