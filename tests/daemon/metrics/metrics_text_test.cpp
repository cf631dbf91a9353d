#include "daemon/metrics/metrics_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <vector>

#include "daemon/protocol/descriptions.hpp"

namespace infuse::daemon {
namespace {

/// Result of parsing by the grammar of the format.
struct Scraped {
  std::map<std::string, std::string> types;  ///< by metric
  std::map<std::string, double> samples;     ///< by metric and labels
  std::vector<std::string> problems;
};

Scraped scrape(const std::string& text) {
  static const std::regex kHelp("# HELP ([a-zA-Z_:][a-zA-Z0-9_:]*) \\S.*");
  static const std::regex kType("# TYPE ([a-zA-Z_:][a-zA-Z0-9_:]*) (counter|gauge)");
  static const std::regex kSample(
      R"re(([a-zA-Z_:][a-zA-Z0-9_:]*)(\{(?:[a-zA-Z_][a-zA-Z0-9_]*="(?:[^"\\\n]|\\\\|\\"|\\n)*",?)+\})? (\S+))re");
  Scraped scraped;
  std::string family, helped;
  std::set<std::string> done;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (std::regex_match(line, match, kHelp)) {
      helped = match[1];
    } else if (std::regex_match(line, match, kType)) {
      if (!done.insert(match[1]).second) scraped.problems.push_back("twice: " + line);
      if (helped != match[1]) scraped.problems.push_back("no help: " + line);
      family = match[1];
      scraped.types[family] = match[2];
    } else if (std::regex_match(line, match, kSample)) {
      if (match[1] != family) scraped.problems.push_back("apart from its family: " + line);
      char* end = nullptr;
      const std::string number = match[3];
      const double value = std::strtod(number.c_str(), &end);
      if (*end != '\0') scraped.problems.push_back("no number: " + line);
      if (!scraped.samples.emplace(match[1].str() + match[2].str(), value).second) {
        scraped.problems.push_back("twice: " + line);
      }
    } else {
      scraped.problems.push_back("not of the format: " + line);
    }
  }
  return scraped;
}

/// Visitor of a description that collects the numbers that no metric exports.
class MissingMetrics {
 public:
  void message(const char*, const char*) {}

  template <class T>
  void field(const char* name, const std::optional<T>& value, const char* text = "",
             const Metric& metric = {}) {
    field(name, value.value_or(T{}), text, metric);
  }
  template <class T>
  void field(const char* name, const T& value, const char* = "", const Metric& metric = {}) {
    if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, Stamp> ||
                  requires { static_cast<double>(value.value); }) {
      ++numbers;
      if (metric.name == nullptr) missing.emplace_back(name);
    } else if constexpr (requires { describe(*this, value); }) {
      describe(*this, value);
    }
  }
  template <class T>
  void field(const char*, const std::vector<T>&, const char* = "", const Metric& = {}) {
    if constexpr (requires(const T& item) { item.latency; }) describe(*this, T());
  }

  size_t numbers = 0;
  std::vector<std::string> missing;
};

template <class Part>
void expect_all_exported(const Part& part) {
  MissingMetrics visitor;
  describe(visitor, part);
  EXPECT_GT(visitor.numbers, 2U);
  EXPECT_THAT(visitor.missing, testing::IsEmpty());
}

TEST(MetricsText, ExportsEveryNumberOfHealth) {
  expect_all_exported(DeviceHealth<LidarStatus>());
  expect_all_exported(DeviceHealth<StreamStatus>());
  expect_all_exported(TaskHealth<OdometryStatus>());
  expect_all_exported(TaskHealth<StreetMapStatus>());
  expect_all_exported(StageStats());
  expect_all_exported(QueueStats());
  expect_all_exported(HealthReport());
}

HealthReport health_report() {
  HealthReport health;
  health.stamp = Stamp::from_ns(1'700'000'000'500'000'000);
  health.drive = from_seconds(12.5);
  LidarStatus top;
  top.counters.packets = 1000;
  top.counters.lost_network = 3;
  top.counters.lost_kernel = 4;
  top.counters.clock.trusted = true;
  top.counters.clock.offset = Duration(-2000);
  top.counters.clock.skew_ppm = 8.5;
  LidarStatus other;
  other.level = Level::kStale;
  other.findings = {{"silent", Level::kStale, Stamp::from_ns(1), "w", "a"}};
  health.sensors = {{"top", "lidar", top}, {"a\"b\\c\nd", "lidar", other}};
  StreamStatus front;
  front.level = Level::kWarn;
  front.counters.received = 7;
  health.streams = {{"front", "camera", front}};
  health.odometry.emplace().status.reason = "no samples";
  health.odometry->status.speed = 3.25;
  health.odometry->status.wheel_scale = 1.25;
  health.calibrations = {
      {"front", {{"drift_confirmed", Level::kError, Stamp::from_ns(1), "w", "a"}}}};
  health.host.emplace().cpu_s = 1.5;
  health.host->stages = {
      {"monitor", {5, Duration(500'000), Duration(2'000'000), Duration(3'000'000)}, 1}};
  health.host->queues = {{"items", 1, 32, 9}};
  health.host->maps = {{"streetmap", "ab", ""}, {"map", "cd", "is damaged"}};
  health.host->ptp_clocks = {{"ptp0", -0.25}};
  return health;
}

TEST(MetricsText, FollowsTheFormat) {
  ProcessStats process;
  process.release = "0.1.0";
  process.alerts = 2;
  process.descriptors = 20;
  const Scraped scraped = scrape(metrics_text(health_report(), process));
  EXPECT_THAT(scraped.problems, testing::IsEmpty());
  const auto value = [&](const std::string& sample) {
    const auto at = scraped.samples.find(sample);
    return at == scraped.samples.end() ? -1e99 : at->second;
  };
  EXPECT_EQ(value("infuse_build_info{release=\"0.1.0\"}"), 1);
  EXPECT_EQ(value("infuse_health_timestamp_seconds"), 1700000000.5);
  EXPECT_EQ(value("infuse_uptime_seconds"), 12.5);
  EXPECT_EQ(value("infuse_alerts_total"), 2);
  EXPECT_EQ(value("process_open_fds"), 20);
  EXPECT_EQ(scraped.samples.count("process_resident_memory_bytes"), 0U);
  EXPECT_EQ(value("infuse_lidar_packets_total{device=\"top\"}"), 1000);
  EXPECT_EQ(value("infuse_lidar_packets_lost_total{device=\"top\",cause=\"network\"}"), 3);
  EXPECT_EQ(value("infuse_lidar_packets_lost_total{device=\"top\",cause=\"kernel\"}"), 4);
  EXPECT_EQ(value("infuse_lidar_clock_trusted{device=\"top\"}"), 1);
  EXPECT_DOUBLE_EQ(value("infuse_lidar_clock_offset_seconds{device=\"top\"}"), -2e-6);
  EXPECT_DOUBLE_EQ(value("infuse_lidar_clock_skew_ratio{device=\"top\"}"), 8.5e-6);
  EXPECT_EQ(value("infuse_level{device=\"front\",kind=\"camera\"}"), 1);
  EXPECT_EQ(value(R"(infuse_level{device="front",kind="calibration"})"), 2);
  EXPECT_EQ(value(R"(infuse_level{device="a\"b\\c\nd",kind="lidar"})"), 3);
  EXPECT_EQ(
      value(R"(infuse_finding{device="a\"b\\c\nd",kind="lidar",id="silent",severity="STALE"})"), 1);
  EXPECT_EQ(value("infuse_stream_received_total{device=\"front\",kind=\"camera\"}"), 7);
  EXPECT_EQ(value("infuse_odometry_usable"), 0);
  EXPECT_EQ(scraped.samples.count("infuse_odometry_speed_meters_per_second"), 0U)
      << "no speed is stated where odometry is not usable";
  EXPECT_EQ(value("infuse_odometry_wheel_scale"), 1.25);
  EXPECT_EQ(value("infuse_stage_latency_seconds{stage=\"monitor\",statistic=\"p99\"}"), 0.002);
  EXPECT_EQ(value("infuse_stage_deadline_misses_total{stage=\"monitor\"}"), 1);
  EXPECT_EQ(value("infuse_queue_lost_total{queue=\"items\"}"), 9);
  EXPECT_EQ(value("process_cpu_seconds_total"), 1.5);
  EXPECT_EQ(value(R"(infuse_map_current{map="streetmap",digest="ab"})"), 1);
  EXPECT_EQ(value(R"(infuse_map_current{map="map",digest="cd"})"), 0);
  EXPECT_EQ(value("infuse_ptp_clock_offset_seconds{clock=\"ptp0\"}"), -0.25);
  EXPECT_EQ(value("infuse_ptp_clock_agrees{clock=\"ptp0\"}"), 0);
  for (const auto& [name, type] : scraped.types) {
    EXPECT_EQ(name.ends_with("_total"), type == "counter") << name;
  }
}

// Prometheus' own checker, if it is installed.
TEST(MetricsText, PromtoolFindsNothingWrong) {
  if (std::system("command -v promtool >/dev/null 2>&1") != 0) GTEST_SKIP() << "no promtool";
  std::FILE* promtool = ::popen("promtool check metrics", "w");
  ASSERT_NE(promtool, nullptr);
  const std::string text =
      metrics_text(health_report(),
                   {.release = "0.1.0", .alerts = 2, .resident_bytes = 1 << 20, .descriptors = 20});
  std::fwrite(text.data(), 1, text.size(), promtool);
  EXPECT_EQ(WEXITSTATUS(::pclose(promtool)), 0);
}

TEST(MetricsText, MeasuresThisProcess) {
  ProcessStats figures;
  measure_process(figures);
  EXPECT_GT(figures.resident_bytes, 1U << 20);
  EXPECT_GE(figures.descriptors, 3U);
}

}  // namespace
}  // namespace infuse::daemon
