#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>

#include "daemon/protocol/json.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

constexpr int64_t kJanuary = 1'767'225'600'000'000'000;  // 2026-01-01, UTC
constexpr int64_t kDay = 86'400'000'000'000;

class HistoryCommandTest : public testing::Test {
 protected:
  HistoryCommandTest() { std::filesystem::create_directories(folder_); }
  ~HistoryCommandTest() override { std::filesystem::remove_all(folder_); }

  void add(const Json& entry) {
    std::ofstream(folder_ / "history.jsonl", std::ios::app) << entry.dump() << "\n";
  }
  /// A camera that has turned about its y axis, and moved along it.
  void add_calibration(int64_t stamp, double yaw_deg, double y_cm) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() =
        Eigen::AngleAxisd(yaw_deg / 57.29577951308232, Eigen::Vector3d::UnitY()).toRotationMatrix();
    T.translation().y() = y_cm / 100;
    Json matrix = Json::array();
    for (int i = 0; i < 16; ++i) matrix.push_back(T.matrix()(i / 4, i % 4));
    add({{"form", 1},
         {"class", "CALIBRATION"},
         {"stamp", stamp},
         {"device", "front"},
         {"state", "OK"},
         {"T_camera_lidar", matrix}});
  }
  ProgramResult history(const std::string& options) const {
    return run_shell_command(programs_folder() + "/infuse history --state " + folder_.string() +
                             " " + options);
  }

  std::filesystem::path folder_ = std::filesystem::temp_directory_path() /
                                  ("infuse-history-command-" + std::to_string(::getpid()));
};

TEST_F(HistoryCommandTest, TheDriftOfEachMonthIsThatOfItsLastCalibration) {
  add_calibration(kJanuary, 0, 0);
  add_calibration(kJanuary + 10 * kDay, 0.05, 0.5);
  add_calibration(kJanuary + 40 * kDay, 0.2, 1);
  const auto result = history("--json");
  ASSERT_EQ(result.code, 0) << result.output;
  EXPECT_TRUE(is_result(result.output, "history"));
  const Json drift = Json::parse(result.output)["drift"];
  ASSERT_EQ(drift.size(), 2U);
  EXPECT_EQ(drift[0]["month"], "2026-01");
  EXPECT_NEAR(drift[0]["rotation_deg"][1].get<double>(), 0.05, 1e-9);
  EXPECT_NEAR(drift[0]["translation_cm"][1].get<double>(), 0.5, 1e-9);
  EXPECT_EQ(drift[1]["month"], "2026-02");
  EXPECT_NEAR(drift[1]["rotation_deg"][1].get<double>(), 0.2, 1e-9);
  EXPECT_THAT(history("").output,
              HasSubstr("drift of front until 2026-02: rotation +0.000 +0.200"));
}

TEST_F(HistoryCommandTest, OtherLinesAreCountedAndOldOnesLeftOut) {
  const auto alert = [&](int64_t stamp, int form) {
    add({{"form", form},
         {"class", "ALERT"},
         {"stamp", stamp},
         {"id", "lidar.silent"},
         {"severity", "STALE"},
         {"what", "no data"}});
  };
  alert(kJanuary, 1);
  alert(kJanuary + 100 * kDay, 1);
  alert(kJanuary + 100 * kDay, 2);
  std::ofstream(folder_ / "history.jsonl", std::ios::app) << "{\"form\":1,\"cl";
  const auto result = history("--json --days 30");
  ASSERT_EQ(result.code, 0) << result.output;
  EXPECT_TRUE(is_result(result.output, "history"));
  const Json shown = Json::parse(result.output);
  EXPECT_EQ(shown["alerts"].size(), 1U);
  EXPECT_EQ(shown["unreadable"], 2);
  EXPECT_THAT(history("").output, HasSubstr("2026-01-01 00:00:00 STALE lidar.silent: no data"));
}

TEST_F(HistoryCommandTest, APageShowsThePosesOverTheMonths) {
  for (int month = 0; month < 12; ++month) {
    add_calibration(kJanuary + 30 * month * kDay, 0.02 * month, 0.1 * month);
    add_calibration(kJanuary + (30 * month + 1) * kDay, 0.02 * month, 0.1 * month);  // a restart
  }
  add({{"form", 1},
       {"class", "ALERT"},
       {"stamp", kJanuary + kDay},
       {"id", "lidar.silent"},
       {"severity", "STALE"},
       {"what", "<script>no data</script>"}});
  const std::string file = (folder_ / "page.html").string();
  const auto result = history("--plot " + file);
  ASSERT_EQ(result.code, 0) << result.output;
  std::ifstream stream(file);
  const std::string page(std::istreambuf_iterator<char>(stream), {});
  const auto count = [&](const std::string& text) {
    size_t times = 0;
    for (size_t at = page.find(text); at != std::string::npos; at = page.find(text, at + 1))
      ++times;
    return times;
  };
  EXPECT_EQ(count("<svg"), 6U);
  EXPECT_EQ(count("<circle"), 6U * 12) << "a restart is no change";
  EXPECT_THAT(page, HasSubstr("11 changes"));
  EXPECT_THAT(page, HasSubstr("2026-11"));
  EXPECT_THAT(page, HasSubstr("+0.220"));
  EXPECT_EQ(count("<script"), 0U);
  EXPECT_THAT(page, HasSubstr("&lt;script>no data"));
  EXPECT_EQ(history("--plot /nonexistent/page.html").code, 3);
}

// Ten thousand changes, as a full history may hold, make a page of bounded size.
TEST_F(HistoryCommandTest, AFullHistoryMakesABoundedPage) {
  for (int i = 0; i < 10'000; ++i) {
    add_calibration(kJanuary + i * (kDay / 30), 0.0001 * i, 0.001 * (i % 50));
  }
  const std::string file = (folder_ / "page.html").string();
  ASSERT_EQ(history("--plot " + file).code, 0);
  EXPECT_LT(std::filesystem::file_size(file), 2'000'000U);
}

TEST_F(HistoryCommandTest, AnEmptyHistoryIsSaid) {
  const auto answer = history("2>&1");
  EXPECT_THAT(answer.output, HasSubstr("no history yet"));
  EXPECT_EQ(answer.code, 1);
}

}  // namespace
}  // namespace infuse::daemon
