#include "tests/study/months/month.hpp"

#include <unistd.h>

#include <fstream>
#include <ostream>
#include <random>

#include "daemon/history/history_file.hpp"

namespace infuse::study {
namespace {

constexpr int64_t kDay = 86'400;
/// Longer than an alert is not recorded again.
constexpr int64_t kMinGap = 700;
/// When the evidence for a drift suffices is a matter of the drawn noise.
constexpr int64_t kDriftSlack = 120;
constexpr int64_t kSlack = 2;

struct DrawnScenario {
  const Scenario* scenario = nullptr;
  int64_t at = 0;
};

struct DrawnMonth {
  std::vector<Fault> faults;
  std::vector<ExpectedAlert> alerts;
  std::vector<DrawnScenario> scenarios;
};

bool is_drift(const std::string& id) {
  return id.find("drift") != std::string::npos || id.find("calibration") != std::string::npos;
}

ExpectedAlert loosened(ExpectedAlert alert, int64_t from, int64_t length) {
  if (alert.raised.whenever) alert.raised = {from, from + length, false, false};
  const int64_t slack = is_drift(alert.id) ? kDriftSlack : kSlack;
  for (SecondsRange* range : {&alert.raised, &alert.cleared}) {
    range->from -= slack;
    range->to += slack;
  }
  if (alert.cleared.never) alert.cleared = {0, 0, false, true};  // not within its scenario
  return alert;
}

DrawnMonth draw_month(const MonthOptions& options, int64_t seconds) {
  std::vector<const Scenario*> candidates;
  for (const Scenario& scenario : scenarios()) {
    if (scenario.returns && scenario.policy == std::string("alert-only")) {
      candidates.push_back(&scenario);
    }
  }
  std::mt19937_64 random(options.seed);
  std::exponential_distribution<double> gap(1 / options.mean_gap_s);
  DrawnMonth month;
  int64_t at = kMinGap;
  for (;;) {
    const Scenario& scenario = *candidates[random() % candidates.size()];
    if (at + scenario.length >= seconds) return month;
    for (Fault fault : parse_faults(scenario.faults)) {
      fault.from += at;
      fault.until += at;
      month.faults.push_back(fault);
    }
    for (const ExpectedAlert& alert : parse_expected(scenario.alerts, at)) {
      month.alerts.push_back(loosened(alert, at, scenario.length));
    }
    // A drift that is suspected just then cannot be recorded.
    if (std::string_view(scenario.faults).find("disk") != std::string_view::npos) {
      const SecondsRange whenever{0, 0, false, true};
      month.alerts.push_back(
          loosened({"infused.record", whenever, whenever, true}, at, scenario.length));
    }
    month.scenarios.push_back({&scenario, at});
    at += scenario.length + kMinGap + static_cast<int64_t>(gap(random));
  }
}

/// The scenario in which a difference lies: "..., 62 s into 'a restart'".
std::string located(const AlertDifference& difference, std::span<const DrawnScenario> scenarios) {
  const DrawnScenario* last = nullptr;
  for (const DrawnScenario& each : scenarios) {
    if (each.at <= difference.second) last = &each;
  }
  if (last == nullptr) return difference.text;
  return difference.text + ", " + std::to_string(difference.second - last->at) + " s into '" +
         last->scenario->name + "'";
}

uint64_t resident_bytes() {
  std::ifstream stat("/proc/self/statm");
  uint64_t total = 0, resident = 0;
  stat >> total >> resident;
  return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace

MonthResult simulate_month(const MonthOptions& options) {
  const auto seconds = static_cast<int64_t>(options.days * static_cast<double>(kDay));
  DrawnMonth month = draw_month(options, seconds);
  MonthResult result;
  result.scenarios = month.scenarios.size();
  result.resident.reserve(static_cast<size_t>(options.days) + 1);
  Simulation simulation({.seed = options.seed}, std::move(month.faults));
  for (int64_t day = kDay; day <= seconds; day += kDay) {
    simulation.run_until(day);
    result.resident.push_back(resident_bytes());
  }
  simulation.run_until(seconds);
  simulation.finish();
  for (const ObservedAlert& alert : simulation.alerts()) {
    result.raised += alert.raised ? 1 : 0;
    result.suspected += alert.raised && alert.id == "front.drift_suspected" ? 1 : 0;
  }
  for (const AlertDifference& each :
       compare_alerts(simulation.alerts(), month.alerts, "front.drift_suspected")) {
    result.differences.push_back(located(each, month.scenarios));
  }
  result.problems = simulation.problems();
  result.max_recorded = simulation.max_recorded_bytes();
  result.recordings = simulation.recordings();
  const std::filesystem::path history = simulation.state() / daemon::kHistoryFile;
  result.state = Simulation::bytes_in(simulation.state()) -
                 Simulation::bytes_in(simulation.state() / "drives");
  std::error_code error;
  result.history = std::filesystem::file_size(history, error);
  return result;
}

bool MonthResult::print(std::ostream& out) const {
  const auto mb = [](uint64_t bytes) { return static_cast<double>(bytes) * 1e-6; };
  out << "scenarios " << scenarios << ", alerts raised " << raised << " (drift suspected "
      << suspected << ")\n"
      << "recordings " << recordings << ", together at most " << mb(max_recorded) << " MB\n"
      << "history " << mb(history) << " MB, state " << mb(state) << " MB\n";
  for (size_t day = 0; day < resident.size(); ++day) {
    out << "day " << day + 1 << ": resident " << mb(resident[day]) << " MB\n";
  }
  for (const std::string& each : differences) out << "alert " << each << "\n";
  for (const std::string& each : problems) out << "problem " << each << "\n";
  return differences.empty() && problems.empty();
}

}  // namespace infuse::study
