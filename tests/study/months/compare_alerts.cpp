#include <sstream>
#include <stdexcept>

#include "tests/study/months/scenarios.hpp"

namespace infuse::study {
namespace {

SecondsRange parse_range(const std::string& text, int64_t offset) {
  if (text == "-") return {0, 0, true, false};
  if (text == "*") return {0, 0, false, true};
  SecondsRange range;
  const size_t dots = text.find("..");
  try {
    range.from = offset + std::stoll(text.substr(0, dots));
    range.to = dots == std::string::npos ? range.from : offset + std::stoll(text.substr(dots + 2));
  } catch (const std::exception&) {
    throw std::invalid_argument("not a time: '" + text + "'");
  }
  return range;
}

bool lies_in(int64_t second, const SecondsRange& range) {
  return range.whenever || (!range.never && second >= range.from && second <= range.to);
}

std::string text_of(const SecondsRange& range) {
  if (range.never) return "-";
  if (range.whenever) return "*";
  return std::to_string(range.from) + ".." + std::to_string(range.to);
}

/// One raising of an alert, and when it was cleared.
struct Raising {
  int64_t raised = 0;
  std::optional<int64_t> cleared;
  bool matched = false;
};

std::string text_of(const std::string& id, const Raising& raising) {
  return id + " " + std::to_string(raising.raised) + " " +
         (raising.cleared ? std::to_string(*raising.cleared) : "-");
}

}  // namespace

std::vector<ExpectedAlert> parse_expected(std::string_view text, int64_t offset) {
  std::vector<ExpectedAlert> alerts;
  std::istringstream stream{std::string(text)};
  for (std::string part; std::getline(stream, part, ';');) {
    std::istringstream words(part);
    std::string id, raised, cleared;
    if (!(words >> id)) continue;
    if (!(words >> raised >> cleared)) throw std::invalid_argument("not an alert: '" + part + "'");
    const SecondsRange when = parse_range(raised, offset);
    alerts.push_back({id, when, parse_range(cleared, offset), when.whenever});
  }
  return alerts;
}

std::vector<AlertDifference> compare_alerts(std::span<const ObservedAlert> observed,
                                            std::span<const ExpectedAlert> expected,
                                            const std::string& tolerated) {
  std::map<std::string, std::vector<Raising>> raisings;
  for (const ObservedAlert& alert : observed) {
    std::vector<Raising>& of_id = raisings[alert.id];
    if (alert.raised) {
      of_id.push_back({alert.second, std::nullopt, false});
    } else if (!of_id.empty()) {
      of_id.back().cleared = alert.second;
    }
  }
  std::vector<AlertDifference> differences;
  std::vector<ExpectedAlert> ordered(expected.begin(), expected.end());
  std::stable_partition(ordered.begin(), ordered.end(),
                        [](const ExpectedAlert& alert) { return !alert.optional; });
  for (const ExpectedAlert& alert : ordered) {
    bool found = alert.optional;
    for (Raising& raising : raisings[alert.id]) {
      const bool cleared = raising.cleared ? lies_in(*raising.cleared, alert.cleared)
                                           : alert.cleared.never || alert.cleared.whenever;
      if (raising.matched || !lies_in(raising.raised, alert.raised) || !cleared) continue;
      raising.matched = found = true;
      if (!alert.optional) break;
    }
    if (!found) {
      differences.push_back(
          {alert.raised.from,
           "missing: " + alert.id + " " + text_of(alert.raised) + " " + text_of(alert.cleared)});
    }
  }
  for (const auto& [id, of_id] : raisings) {
    for (const Raising& raising : of_id) {
      if (!raising.matched && id != tolerated) {
        differences.push_back({raising.raised, "not expected: " + text_of(id, raising)});
      }
    }
  }
  return differences;
}

}  // namespace infuse::study
