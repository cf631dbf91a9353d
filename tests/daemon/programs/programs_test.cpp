// The programs as a person runs them: what they print, and their exit codes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <thread>

#include <spdlog/fmt/fmt.h>

#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// Runs a program; `output` holds standard output and standard error.
ProgramResult run(const std::string& command) {
  return run_shell_command("{ " + programs_folder() + "/" + command + "; } 2>&1");
}

class ProgramsTest : public testing::Test {
 protected:
  void make(double seconds, double loss = 0) {
    fixtures::CaptureOptions options;
    options.model = &velodyne::lidar_model(velodyne::Model::kVlp16);
    options.duration = from_seconds(seconds);
    options.loss = loss;
    const auto made = fixtures::make_capture(path_, options);
    ASSERT_TRUE(made);
    truth_ = *made;
  }
  std::string path() const { return path_.string(); }
  std::string socket() const { return " --socket " + (folder_ / "s").string(); }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "street.pcap";
  fixtures::CaptureTruth truth_;
};

TEST_F(ProgramsTest, ExitCodesAreAsDocumented) {
  EXPECT_EQ(run("infused --version").code, 0);
  EXPECT_EQ(run("infuse --help").code, 0);
  EXPECT_EQ(run("infuse").code, 2);
  EXPECT_EQ(run("infuse nonsense").code, 2);
  EXPECT_EQ(run("infused --rate").code, 2);
  const ProgramResult live = run("infused");
  EXPECT_EQ(live.code, 2);
  EXPECT_THAT(live.output, HasSubstr("nothing to do"));
  EXPECT_EQ(run("infused --replay /nonexistent" + socket()).code, 3);
  EXPECT_EQ(run("infuse inspect /nonexistent").code, 3);
  EXPECT_EQ(run("infuse decode /nonexistent -o x.pcd").code, 3);
  EXPECT_EQ(run("infuse decode /nonexistent -o x.xyz").code, 2);
  const ProgramResult nobody = run("infuse status" + socket());
  EXPECT_EQ(nobody.code, 1);
  EXPECT_THAT(nobody.output, HasSubstr("is infused running?"));
  make(0.5);
  EXPECT_EQ(run("infused --replay " + path() + " --rate 0" + socket()).code, 2);
  EXPECT_EQ(run("infused --replay " + path() + " --model X" + socket()).code, 2);
  EXPECT_EQ(run("infused --replay " + path() + " --reports /nonexistent/x" + socket()).code, 2);
}

TEST_F(ProgramsTest, ASimulationIsNotWrittenAmongOtherFiles) {
  if (!std::filesystem::exists(programs_folder() + "/infuse-simulate")) {
    GTEST_SKIP() << "infuse-simulate is not built";
  }
  std::ofstream(folder_ / "mine") << "text";
  const ProgramResult refused =
      run("infuse-simulate " + source_folder() + "/fixtures/scenarios/street_quick.toml -o " +
          (folder_ / "").string());
  EXPECT_EQ(refused.code, 2) << refused.output;
  EXPECT_THAT(refused.output, HasSubstr("is not empty, and no drive"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_ / ""), {}), 1);
}

TEST_F(ProgramsTest, AConfigurationIsCheckedWithoutStarting) {
  const auto file = folder_ / "infused.toml";
  std::ofstream(file) << "[health]\nstale_after_s = 5\n";
  EXPECT_EQ(run("infused --check-config --config " + file.string()).code, 0);
  std::ofstream(file) << "[health]\n\nstale = 5\n";
  const ProgramResult wrong = run("infused --check-config --config " + file.string());
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.output, HasSubstr("infused.toml:3: unknown key 'stale'"));
  EXPECT_EQ(run("infused --check-config").code, 2);
}

TEST_F(ProgramsTest, TheSummaryIsOneObjectOrReadable) {
  make(2);
  const ProgramResult text = run("infused --replay " + path() + socket());
  EXPECT_EQ(text.code, 0);
  EXPECT_THAT(text.output, HasSubstr("VLP-16, OK (inferred: product byte 0x22"));
  const ProgramResult machine = run("infused --json --replay " + path() + socket());
  ASSERT_EQ(machine.code, 0);
  const std::string object = machine.output.substr(machine.output.rfind("\n{") + 1);
  EXPECT_TRUE(is_result(object, "replay"));
  const json summary = json::parse(object);
  EXPECT_EQ(summary["packets"], truth_.packets);
  EXPECT_EQ(summary["returns"], truth_.returns);
  EXPECT_EQ(summary["packets_lost"], 0);
  EXPECT_NEAR(summary["drive_s"].get<double>(), 2, 0.01);
  EXPECT_GT(summary["cpu_s"].get<double>(), 0);
  EXPECT_GE(summary["latency_ms"]["max"].get<double>(), summary["latency_ms"]["p50"].get<double>());
}

TEST_F(ProgramsTest, ReportsAreTheSameBytesAtEveryRate) {
  make(1.2);
  const auto reports = [&](const std::string& rate) {
    const auto file = folder_ / rate;
    EXPECT_EQ(run("infused --replay " + path() + " --rate " + rate + " --reports " + file.string() +
                  socket())
                  .code,
              0);
    std::ifstream stream(file, std::ios::binary);
    return std::string((std::istreambuf_iterator<char>(stream)), {});
  };
  const std::string fastest = reports("max");
  EXPECT_GT(fastest.size(), 1000U);
  EXPECT_EQ(reports("10"), fastest);
  EXPECT_EQ(reports("1"), fastest);
}

TEST_F(ProgramsTest, InspectPrintsStreamsDevicesAndProblems) {
  make(3, 0.05);
  const ProgramResult machine = run("infuse inspect --json " + path());
  ASSERT_EQ(machine.code, 0);
  EXPECT_TRUE(is_result(machine.output, "inspect"));
  const json found = json::parse(machine.output);
  ASSERT_EQ(found["streams"].size(), 2U);
  EXPECT_EQ(found["streams"][0]["what"], "lidar packets");
  EXPECT_EQ(found["streams"][0]["count"], truth_.packets);
  EXPECT_EQ(found["streams"][0]["sender"], "192.168.1.201");
  EXPECT_EQ(found["streams"][1]["count"], truth_.position_packets);
  EXPECT_EQ(found["devices"][0]["model"], "VLP-16");
  EXPECT_THAT(found["problems"].dump(), HasSubstr("packets lost"));
  const ProgramResult text = run("infuse inspect " + path());
  EXPECT_THAT(text.output, HasSubstr("lidar packets from 192.168.1.201 to port 2368"));
}

TEST_F(ProgramsTest, DecodeWritesASweepToAFile) {
  make(1);
  const auto file = folder_ / "sweep.csv";
  ASSERT_EQ(run("infuse decode " + path() + " --sweep 3 -o " + file.string()).code, 0);
  std::ifstream stream(file);
  int lines = 0;
  for (std::string line; std::getline(stream, line);) ++lines;
  EXPECT_GT(lines, 20'000);  // one revolution of a VLP-16 in a street
  EXPECT_EQ(run("infuse decode " + path() + " --sweep 99 -o " + file.string()).code, 1);
  const ProgramResult all =
      run("infuse decode --json " + path() + " -o " + (folder_ / "x.pcd").string());
  ASSERT_EQ(all.code, 0);
  EXPECT_EQ(json::parse(all.output)["returns"], truth_.returns);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "x-000000.pcd"));
}

TEST_F(ProgramsTest, StatusAndWatchQueryARunningReplay) {
  make(4);
  ProgramResult daemon;
  std::thread thread([&] { daemon = run("infused --replay " + path() + " --rate 1" + socket()); });
  ProgramResult status;
  for (int i = 0; i < 200 && status.output.find("HEALTH") == std::string::npos; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    status = run("infuse status" + socket());
  }
  EXPECT_EQ(status.code, 0);
  EXPECT_THAT(status.output, HasSubstr("HEALTH OK"));
  EXPECT_THAT(status.output, HasSubstr("lidar: "));
  EXPECT_EQ(run("infuse watch NONSENSE" + socket()).code, 2);
  const ProgramResult watched =
      run("infuse watch --json" + socket());  // returns when the daemon ends
  thread.join();
  EXPECT_EQ(watched.code, 0);
  EXPECT_EQ(daemon.code, 0);
  std::istringstream lines(watched.output);
  int sweeps = 0;
  for (std::string line; std::getline(lines, line);) {
    ASSERT_TRUE(is_valid_message(line));
    sweeps += json::parse(line)["class"] == "SWEEP";
  }
  EXPECT_GT(sweeps, 3);
}

TEST_F(ProgramsTest, ATerminationSignalEndsWithASummary) {
  make(30);
  const ProgramResult stopped =
      run("infused --json --replay " + path() + " --rate 1" + socket() + " & pid=$!; until [ -S " +
          (folder_ / "s").string() + " ]; do sleep 0.1; done; kill -TERM $pid; wait $pid");
  EXPECT_EQ(stopped.code, 0);
  EXPECT_THAT(stopped.output, HasSubstr("\"stopped\":true"));
}

TEST_F(ProgramsTest, StreetMapsAreMadeAndRefused) {
  const std::string map = " -o " + (folder_ / "x.map").string();
  const std::string altfeld = source_folder() + "/fixtures/maps/altfeld.osm";
  const std::string image = (folder_ / "x.png").string();
  const ProgramResult made = run("infuse streetmap --json " + altfeld + map + " --image " + image);
  ASSERT_EQ(made.code, 0) << made.output;
  EXPECT_TRUE(is_result(made.output, "streetmap"));
  const json report = json::parse(made.output);
  EXPECT_EQ(report["kinds"]["building"], 115);
  EXPECT_EQ(report["bytes"], std::filesystem::file_size(folder_ / "x.map"));
  EXPECT_GT(std::filesystem::file_size(image), 1000U);
  // The image converts to a map again if its scale is given.
  EXPECT_EQ(run("infuse streetmap " + image + map).code, 2);
  EXPECT_EQ(run("infuse streetmap --scale 0.2 " + image + map).code, 0);
  EXPECT_EQ(run("infuse streetmap --cell 0 " + altfeld + map).code, 2);
  EXPECT_EQ(run("infuse streetmap /nonexistent.osm" + map).code, 3);
  EXPECT_EQ(run("infuse streetmap " + altfeld + " -o /nonexistent/x.map").code, 1);
}

TEST_F(ProgramsTest, EvaluateScoresATrajectoryByHandMadeErrors) {
  std::string truth, result;
  for (int i = 0; i < 200; ++i) {  // 2 m/s along x; the estimate is 1 % short
    truth += fmt::format("{}.0 {} 0 0 0 0 0 1\n", i, 2.0 * i);
    result += fmt::format("{}.0 {} 0 0 0 0 0 1\n", i, 2.0 * i * 0.99);
  }
  std::ofstream(folder_ / "truth.tum") << truth;
  std::ofstream(folder_ / "result.tum") << result;
  const std::string files =
      (folder_ / "result.tum").string() + " " + (folder_ / "truth.tum").string();
  const ProgramResult ran = run("infuse evaluate " + files + " --align first --json");
  ASSERT_EQ(ran.code, 0) << ran.output;
  EXPECT_TRUE(is_result(ran.output, "evaluate"));
  const json score = json::parse(ran.output);
  EXPECT_EQ(score["paired"], 200);
  EXPECT_NEAR(score["absolute"]["translation_m"]["max"].get<double>(), 0.01 * 398, 1e-6);
  EXPECT_NEAR(score["relative"]["translation_m"]["mean"].get<double>(), 0.02, 1e-6);
  EXPECT_NEAR(score["kitti"]["translation_percent"].get<double>(), 1, 0.02);
  EXPECT_THAT(run("infuse evaluate " + files).output, HasSubstr("KITTI score: 1.0"));
  EXPECT_EQ(run("infuse evaluate " + files + " --align sideways").code, 2);
  EXPECT_EQ(run("infuse evaluate nothing.tum " + files).code, 2);
  EXPECT_EQ(run("infuse evaluate nothing.tum " + (folder_ / "truth.tum").string()).code, 3);
}

TEST_F(ProgramsTest, EvaluateScoresACalibrationInDegreesCentimetresAndPixels) {
  const auto rig = [&](const char* name, double x) {
    std::ofstream(folder_ / name) << fmt::format(
        "[[lidar]]\nname = \"top\"\nT_vehicle_lidar = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2, 0, 0, "
        "0, 1]\n[[camera]]\nname = \"front\"\nlidar = \"top\"\nwidth = 640\n"
        "height = 480\nfx = 400\nfy = 400\ncx = 319.5\ncy = 239.5\n"
        "T_camera_lidar = [0, -1, 0, {},  0, 0, -1, 0,  1, 0, 0, 0,  0, 0, 0, 1]\n",
        x);
    return (folder_ / name).string();
  };
  const std::string truth = rig("truth.toml", 0);
  const ProgramResult ran =
      run("infuse evaluate " + rig("result.toml", 0.05) + " " + truth + " --json");
  ASSERT_EQ(ran.code, 0) << ran.output;
  EXPECT_TRUE(is_result(ran.output, "evaluate"));
  const json camera = json::parse(ran.output)["cameras"][0];
  EXPECT_EQ(camera["camera"], "front");
  EXPECT_NEAR(camera["translation_m"].get<double>(), 0.05, 1e-9);
  EXPECT_NEAR(camera["rotation_deg"].get<double>(), 0, 1e-6);
  std::ofstream(folder_ / "result.json")
      << R"({"T_camera_lidar": [0,-1,0,0, 0,0,-1,0, 1,0,0,0.02, 0,0,0,1]})";
  const ProgramResult other =
      run("infuse evaluate " + (folder_ / "result.json").string() + " " + truth);
  EXPECT_EQ(other.code, 0);
  EXPECT_THAT(other.output, HasSubstr("2.00 cm"));
  std::ofstream(folder_ / "bad.json") << R"({"T_camera_lidar": [1, 2]})";
  EXPECT_EQ(run("infuse evaluate " + (folder_ / "bad.json").string() + " " + truth).code, 3);
}

}  // namespace
}  // namespace infuse::daemon
