#include "daemon/owner/watch_screen.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace infuse::daemon {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

Json alert(const std::string& state) {
  return {{"class", "ALERT"},        {"device", "front"},   {"id", "drift_confirmed"},
          {"state", state},          {"severity", "error"}, {"what", "the camera has moved"},
          {"advice", "calibrate it"}};
}

TEST(WatchScreen, ShowsEvidenceAgainstItsThreshold) {
  WatchScreen screen;
  EXPECT_THAT(screen.text(80, 3), StartsWith("infused: waiting for HEALTH"));
  screen.add(
      {{"class", "CALIBRATION"},
       {"device", "front"},
       {"state", "SUSPECTED"},
       {"evaluations", 7},
       {"evidence", {{"axis", "rotation about y"}, {"nats", 6.0}, {"threshold_nats", 12.0}}}});
  const std::string text = screen.text(120, 10);
  // Half of 24 cells.
  EXPECT_THAT(text, HasSubstr("front        SUSPECTED    [############............] 6.0 of 12.0"));
  EXPECT_THAT(text, HasSubstr("rotation about y, 7 evaluations"));
}

TEST(WatchScreen, AnAlertIsShownWhileItIsRaised) {
  WatchScreen screen;
  screen.add({{"class", "HEALTH"}, {"level", "ERROR"}, {"drive_s", 12.0}});
  screen.add(alert("raised"));
  EXPECT_THAT(screen.text(80, 10), HasSubstr("ERROR (running for 12 s), 1 alert(s)"));
  EXPECT_THAT(screen.text(80, 10), HasSubstr("! error front: the camera has moved"));
  screen.add(alert("cleared"));
  EXPECT_THAT(screen.text(80, 10), Not(HasSubstr("moved")));
}

TEST(WatchScreen, HasTheSizeOfTheTerminalAndNoControlCharacters) {
  WatchScreen screen;
  Json hostile = alert("raised");
  hostile["what"] = "\x1b[2J ± 1 m and much more than fits into the line of a narrow terminal";
  screen.add(hostile);
  screen.add({{"class", "POSE"}, {"frame", "odom"}, {"usable", true}});
  for (const auto& [columns, rows] : {std::pair{20UL, 4UL}, {7UL, 2UL}, {80UL, 1UL}}) {
    const std::string text = screen.text(columns, rows);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), static_cast<std::ptrdiff_t>(rows) - 1);
    size_t characters = 0;
    for (const char c : text) {
      EXPECT_NE(c, '\x1b');
      characters = c == '\n' ? 0 : characters + ((c & 0xC0) != 0x80 ? 1 : 0);
      EXPECT_LE(characters, columns);
    }
  }
  EXPECT_THAT(screen.text(60, 2), HasSubstr("… more"));
}

}  // namespace
}  // namespace infuse::daemon
