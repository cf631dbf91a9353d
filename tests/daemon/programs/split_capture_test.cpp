// A recording that tcpdump split is read by every command like the recording in one file.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "fixtures/scene/capture.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/folders.hpp"
#include "tests/raw_capture.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;
using testing::HasSubstr;

const std::string kBinaries = programs_folder();

class SplitCaptureTest : public testing::Test {
 protected:
  SplitCaptureTest() {
    fixtures::CaptureOptions options;
    options.duration = from_seconds(0.6);
    EXPECT_TRUE(fixtures::make_capture(whole_, options));
    std::filesystem::create_directory(folder_ / "ring");
  }

  /// Writes the records from `begin` to `end`, as shares of all, to a part.
  void write_part(const std::string& name, double begin, double end) {
    const RawCapture capture = RawCapture::read(whole_);
    const auto at = [&](double share) {
      return capture.records.begin() +
             static_cast<std::ptrdiff_t>(share * static_cast<double>(capture.records.size()));
    };
    RawCapture{capture.header, {at(begin), at(end)}}.write(folder_ / "ring" / name);
  }

  /// Parts of a ring of three files that has come round; they end within sweeps.
  void split() {
    write_part("x.pcap0", 0.71, 1);
    write_part("x.pcap1", 0, 0.33);
    write_part("x.pcap2", 0.33, 0.71);
  }

  std::vector<std::string> ways_to_name_the_parts() const {
    const std::string ring = folder_ / "ring";
    return {ring + "/x.pcap0", ring + "/"};
  }

  ProgramResult shell(const std::string& command) const {
    return run_shell_command("cd " + folder_.path().string() + " && " + command + " 2>/dev/null");
  }
  ProgramResult run(const std::string& command) const { return shell(kBinaries + "/" + command); }

  ScratchFolder folder_;
  std::filesystem::path whole_ = folder_ / "whole.pcap";
};

TEST_F(SplitCaptureTest, InspectSeesTheWhole) {
  split();
  json whole = json::parse(run("infuse inspect --json whole.pcap").output);
  for (const char* path : {"ring/x.pcap0", "'ring/x.pcap*'"}) {
    json parts = json::parse(run("infuse inspect --json " + std::string(path)).output);
    for (json* found : {&whole, &parts}) {
      found->erase("path");
      for (json& device : (*found)["devices"]) device.erase("endpoint");
    }
    EXPECT_EQ(parts, whole) << path;
  }
}

TEST_F(SplitCaptureTest, DecodeAndReplayGiveTheSameBytes) {
  split();
  ASSERT_EQ(run("infuse decode whole.pcap -o whole.bin").code, 0);
  ASSERT_EQ(run("infused --replay whole.pcap --reports whole.jsonl").code, 0);
  const std::string sweeps = shell("cat whole-*.bin | sha256sum").output;
  const std::string reports = shell("grep SWEEP whole.jsonl").output;
  EXPECT_GE(std::ranges::count(reports, '\n'), 6);
  for (const std::string& path : ways_to_name_the_parts()) {
    ASSERT_EQ(run("infuse decode " + path + " -o parts.bin").code, 0) << path;
    EXPECT_EQ(shell("cat parts-*.bin | sha256sum").output, sweeps) << path;
    ASSERT_EQ(run("infused --replay " + path + " --reports parts.jsonl").code, 0) << path;
    EXPECT_EQ(shell("grep SWEEP parts.jsonl").output, reports) << path;
  }
}

TEST_F(SplitCaptureTest, AMissingPartIsNamed) {
  write_part("x.pcap", 0, 0.33);
  write_part("x.pcap2", 0.71, 1);
  const json found = json::parse(run("infuse inspect --json ring/x.pcap").output);
  EXPECT_THAT(found["problems"].dump(), HasSubstr("s are missing after x.pcap"));
}

TEST_F(SplitCaptureTest, InspectListsTheCapturesOfAFolder) {
  split();
  write_part("short.pcap", 0, 0.5);
  const ProgramResult good = run("infuse inspect ring");
  EXPECT_EQ(good.code, 0);
  EXPECT_THAT(good.output, HasSubstr("short.pcap: HDL-32E, "));
  EXPECT_THAT(good.output, HasSubstr("x.pcap0: HDL-32E, "));
  EXPECT_THAT(good.output, HasSubstr("2 captures, 2 with a lidar, 0 with problems: "));
  EXPECT_EQ(std::ranges::count(good.output, '\n'), 3);

  shell("head -c 10 whole.pcap > ring/cut.pcap");
  RawCapture{RawCapture::read(whole_).header, {}}.write(folder_ / "ring" / "empty.pcap");
  const ProgramResult bad = run("infuse inspect --json ring/");
  EXPECT_EQ(bad.code, 1);
  EXPECT_TRUE(is_result(bad.output, "inspect"));
  const json found = json::parse(bad.output);
  ASSERT_EQ(found["captures"].size(), 4U);
  EXPECT_THAT(found["captures"][0]["problems"].dump(), HasSubstr("cannot be read as pcap"));
  EXPECT_EQ(found["captures"][3]["problems"], json::array());
  EXPECT_EQ(found["totals"]["captures"], 4);
  EXPECT_EQ(found["totals"]["with_lidar"], 2);
  EXPECT_EQ(found["totals"]["with_problems"], 2);
}

}  // namespace
}  // namespace infuse::daemon
