// The expressions of packaging/fleet (alert rules, dashboard) name metrics and labels that the
// daemon exports.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <vector>

#include "daemon/metrics/metrics_text.hpp"
#include "daemon/protocol/descriptions.hpp"
#include "drivers/text/text_file.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

using Names = std::set<std::string>;

/// Visitor of a description that collects the names of the metrics, also of what is absent.
class MetricNames {
 public:
  void message(const char*, const char*) {}

  template <class T>
  void field(const char* name, const std::optional<T>& value, const char* text = "",
             const Metric& metric = {}) {
    field(name, value.value_or(T{}), text, metric);
  }
  template <class T>
  void field(const char*, const T& value, const char* = "", const Metric& metric = {}) {
    if (metric.name != nullptr) names.insert(metric.name);
    if constexpr (requires { describe(*this, value); }) describe(*this, value);
  }
  template <class T>
  void field(const char*, const std::vector<T>&, const char* = "", const Metric& = {}) {
    if constexpr (requires(const T& item) { item.latency; }) describe(*this, T());
  }

  Names names;
};

/// The names of all metrics, of the descriptions and of a text.
Names exported() {
  MetricNames visitor;
  describe(visitor, DeviceHealth<LidarStatus>());
  describe(visitor, DeviceHealth<StreamStatus>());
  describe(visitor, TaskHealth<OdometryStatus>());
  describe(visitor, TaskHealth<StreetMapStatus>());
  describe(visitor, TaskHealth<MapStatus>());
  describe(visitor, StageStats());
  describe(visitor, QueueStats());
  describe(visitor, StoreStatus());
  describe(visitor, SystemClock());
  describe(visitor, HostStats());
  describe(visitor, HealthReport());
  HealthReport health;
  LidarStatus lidar;
  lidar.findings = {{"silent", Level::kStale, Stamp::from_ns(1), "", ""}};
  health.sensors = {{"top", "lidar", lidar}};
  const std::string text =
      metrics_text(health, {.release = "0", .resident_bytes = 1, .descriptors = 1});
  const std::regex type("# TYPE ([a-z_]+) ");
  for (std::sregex_iterator at(text.begin(), text.end(), type), end; at != end; ++at) {
    visitor.names.insert((*at)[1]);
  }
  return visitor.names;
}

Names metrics_in(const std::string& expression) {
  const std::regex metric("(infuse|process)_[a-z0-9_]+");
  // Values of labels are not metrics.
  const std::string code = std::regex_replace(expression, std::regex("\"[^\"]*\""), "");
  Names names;
  for (std::sregex_iterator at(code.begin(), code.end(), metric), end; at != end; ++at) {
    names.insert(at->str());
  }
  return names;
}

Names unknown_of(const Names& used) {
  const Names known = exported();
  Names unknown;
  std::set_difference(used.begin(), used.end(), known.begin(), known.end(),
                      std::inserter(unknown, unknown.end()));
  return unknown;
}

std::string fleet_file(const char* name) {
  const auto text =
      text::read_text(std::filesystem::path(source_folder()) / "packaging/fleet" / name, 1 << 20);
  EXPECT_TRUE(text.has_value()) << name;
  return text.value_or("");
}

TEST(FleetFiles, TheAlertRulesNameMetricsThatExist) {
  // Of each rule, what stands between "expr:" and "for:" or "labels:".
  const std::string text = fleet_file("prometheus/rules.yml");
  const std::regex expression(R"(expr:([^\0]*?)\n +(for|labels):)");
  Names used;
  int rules = 0;
  for (std::sregex_iterator at(text.begin(), text.end(), expression), end; at != end; ++at) {
    used.merge(metrics_in((*at)[1]));
    ++rules;
  }
  EXPECT_EQ(rules, 10);
  EXPECT_GE(used.size(), 9U);
  EXPECT_THAT(unknown_of(used), IsEmpty());
}

TEST(FleetFiles, TheDashboardNamesMetricsThatExist) {
  const auto dashboard = nlohmann::json::parse(fleet_file("grafana/vehicles.json"), nullptr, false);
  ASSERT_TRUE(dashboard.is_object());
  Names used;
  for (const auto& panel : dashboard["panels"]) {
    for (const auto& target : panel["targets"]) {
      const Names metrics = metrics_in(target["expr"].get<std::string>());
      EXPECT_FALSE(metrics.empty()) << panel["title"];
      used.insert(metrics.begin(), metrics.end());
    }
  }
  used.merge(metrics_in(dashboard["templating"]["list"][1]["query"].get<std::string>()));
  EXPECT_GE(used.size(), 18U);
  EXPECT_THAT(unknown_of(used), IsEmpty());
}

TEST(FleetFiles, AMetricThatDoesNotExistIsSeen) {
  EXPECT_THAT(unknown_of(metrics_in("rate(infuse_no_such_total{job=\"infuse_x\"}[5m])")),
              SizeIs(1));
}

}  // namespace
}  // namespace infuse::daemon
