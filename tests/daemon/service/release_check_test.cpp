#include "daemon/service/release_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "daemon/calibration/saved_calibrations.hpp"
#include "daemon/history/saved_state.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

class SelfTestTest : public testing::Test {
 protected:
  ExitCode test() {
    out_.str("");
    return self_test(config_, folder_.path(), out_);
  }
  /// Names of what is in the state directory.
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      names.push_back(entry.path().filename().string());
    }
    return names;
  }

  const ScratchFolder folder_;
  Config config_;
  std::ostringstream out_;
};

TEST_F(SelfTestTest, AnEmptyStateIsFineAndStaysEmpty) {
  EXPECT_EQ(test(), kDone) << out_.str();
  EXPECT_THAT(files(), testing::IsEmpty());
  EXPECT_THAT(out_.str(), HasSubstr("ok: generated packets"));
}

TEST_F(SelfTestTest, TheStateOfThisReleaseIsReadAndLeftAlone) {
  const std::string state = format_state({.starts = 3});
  const std::string cameras = format_calibrations(
      {.next_number = 2, .cameras = {{.camera = "front", .in_use = 1, .known = {{.number = 1}}}}});
  folder_.write(kSavedStateFile, state);
  folder_.write(kCalibrationsFile, cameras);
  folder_.write("history.jsonl", "{\"form\":1}\n{\"form\":2}\n{\"fo\n");
  EXPECT_EQ(test(), kDone) << out_.str();
  EXPECT_THAT(out_.str(), HasSubstr("note: 2 of them are damaged or of another release"));
  EXPECT_EQ(folder_.read(kSavedStateFile), state);
  EXPECT_EQ(folder_.read(kCalibrationsFile), cameras);
  EXPECT_EQ(files().size(), 3U);
}

TEST_F(SelfTestTest, TheStateOfANewerReleaseFails) {
  const std::vector<std::pair<const char*, int>> files = {{kSavedStateFile, kSavedStateForm},
                                                          {kCalibrationsFile, kCalibrationsForm}};
  for (const auto& [file, form] : files) {
    const std::string text = "{\"form\": " + std::to_string(form + 1) + ", \"more\": 1}";
    folder_.write(file, text);
    EXPECT_EQ(test(), kFailure);
    EXPECT_THAT(out_.str(), HasSubstr("failed: "));
    EXPECT_THAT(out_.str(), HasSubstr("newer release: form " + std::to_string(form + 1) +
                                      ", this one reads up to " + std::to_string(form)));
    EXPECT_EQ(folder_.read(file), text);
    std::filesystem::remove(folder_ / file);
  }
}

// The release before cannot use it either.
TEST_F(SelfTestTest, DamagedStateIsANote) {
  folder_.write(kSavedStateFile, "{\"form\": 1, \"sta");
  folder_.write(kCalibrationsFile, "{\"form\": 1, \"cameras\": [{}]}");
  EXPECT_EQ(test(), kDone);
  EXPECT_THAT(out_.str(), HasSubstr("damaged calibration file"));
  EXPECT_THAT(out_.str(), HasSubstr("not a state file"));
}

TEST_F(SelfTestTest, ExitCodesTellWhatFailed) {
  config_.streetmap.map = "missing.map";
  EXPECT_EQ(test(), kUnreadable);
  EXPECT_THAT(out_.str(), HasSubstr("missing.map"));
  config_ = {};
  config_.rig = "missing.toml";
  EXPECT_EQ(test(), kUsage);
  EXPECT_THAT(out_.str(), HasSubstr("missing.toml"));
  config_ = {};
  std::ostringstream out;
  EXPECT_NE(self_test(config_, folder_ / "none" / "such", out), kDone);
}

TEST(DecodeGeneratedTurns, GivesSweepsOfTheirRadius) { EXPECT_TRUE(decode_generated_turns()); }

}  // namespace
}  // namespace infuse::daemon
