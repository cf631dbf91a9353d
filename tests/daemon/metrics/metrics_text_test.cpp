#include "daemon/metrics/metrics_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "daemon/metrics/metric_definitions.hpp"

namespace infuse::daemon {
namespace {

/// What a scraper reads, by the format's own grammar.
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

/// Every path of HEALTH's schema below `schema` whose value is a number or a truth.
void collect_numbers(const Json& schema, const std::string& path, std::vector<std::string>& paths) {
  if (schema.contains("properties")) {
    for (const auto& [key, value] : schema["properties"].items()) {
      collect_numbers(value, path + "/" + key, paths);
    }
  } else if (schema.contains("type")) {
    const Json& type = schema["type"];
    if (type == "number" || type == "integer" || type == "boolean") paths.push_back(path);
  }
}

std::vector<std::string> paths_of(std::span<const MetricDefinition> figures) {
  std::vector<std::string> paths;
  for (const MetricDefinition& figure : figures) paths.push_back(figure.path);
  return paths;
}

TEST(MetricsText, HasEveryNumberOfTheSchema) {
  std::ifstream file(std::string(INFUSE_SOURCE_DIR) + "/daemon/protocol/health.schema.json");
  const Json schema = Json::parse(file)["properties"];
  const auto expect_all = [](const Json& table, std::span<const MetricDefinition> figures) {
    std::vector<std::string> numbers;
    collect_numbers(table, "", numbers);
    EXPECT_GT(numbers.size(), 2U);
    EXPECT_THAT(paths_of(figures), testing::IsSupersetOf(numbers));
  };
  expect_all(schema["sensors"]["items"], lidar_metrics());
  expect_all(schema["streams"]["items"], stream_metrics());
  expect_all(schema["odometry"], odometry_metrics());
  expect_all(schema["streetmap"], streetmap_metrics());
  expect_all(schema["host"]["properties"]["stages"]["items"], stage_metrics());
  expect_all(schema["host"]["properties"]["queues"]["items"], queue_metrics());
  EXPECT_THAT(paths_of(report_metrics()),
              testing::UnorderedElementsAre("/stamp", "/drive_s", "/host/cpu_s"));
}

const Json kHealth = Json::parse(R"({
  "class":"HEALTH","stamp":1700000000500000000,"drive_s":12.5,"level":"WARN",
  "sensors":[
    {"device":"top","level":"OK","packets":1000,"losses":{"network":3,"kernel":4},"findings":[],
     "clock":{"trusted":true,"offset_ns":-2000,"skew_ppm":8.5}},
    {"device":"a\"b\\c\nd","level":"STALE","packets":0,"losses":{"network":0},"findings":[
      {"id":"silent","level":"STALE","since":1,"what":"w","advice":"a"}]}],
  "streams":[{"device":"front","kind":"camera","level":"WARN","received":7,"findings":[]}],
  "odometry":{"level":"OK","usable":false,"speed":3.25,"findings":[]},
  "host":{"cpu_s":1.5,
    "stages":[{"stage":"monitor","count":5,"latency_ms":{"p50":0.5,"p99":2,"max":3},"deadline_misses":1}],
    "queues":[{"queue":"items","depth":1,"capacity":32,"lost":9}]}})");

TEST(MetricsText, IsWhatAScraperReads) {
  ProcessStats process;
  process.release = "0.1.0";
  process.alerts = 2;
  process.descriptors = 20;
  const Scraped scraped = scrape(metrics_text(kHealth, process));
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
  EXPECT_EQ(value(R"(infuse_level{device="a\"b\\c\nd",kind="lidar"})"), 3);
  EXPECT_EQ(
      value(R"(infuse_finding{device="a\"b\\c\nd",kind="lidar",id="silent",severity="STALE"})"), 1);
  EXPECT_EQ(value("infuse_stream_received_total{device=\"front\",kind=\"camera\"}"), 7);
  EXPECT_EQ(value("infuse_odometry_usable"), 0);
  EXPECT_EQ(value("infuse_odometry_speed_meters_per_second"), 3.25);
  EXPECT_EQ(value("infuse_stage_latency_seconds{stage=\"watch\",statistic=\"p99\"}"), 0.002);
  EXPECT_EQ(value("infuse_stage_deadline_misses_total{stage=\"watch\"}"), 1);
  EXPECT_EQ(value("infuse_queue_lost_total{queue=\"items\"}"), 9);
  EXPECT_EQ(value("process_cpu_seconds_total"), 1.5);
  for (const auto& [name, type] : scraped.types) {
    EXPECT_EQ(name.ends_with("_total"), type == "counter") << name;
  }
}

// Prometheus' own judge, where it is installed.
TEST(MetricsText, PromtoolFindsNothingWrong) {
  if (std::system("command -v promtool >/dev/null 2>&1") != 0) GTEST_SKIP() << "no promtool";
  std::FILE* promtool = ::popen("promtool check metrics", "w");
  ASSERT_NE(promtool, nullptr);
  const std::string text = metrics_text(kHealth, {"0.1.0", 2, 1 << 20, 20});
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
