// infuse fleet: exit codes, files and messages of the command; the sums are tested in
// tests/daemon/tools/fleet.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/text/text_file.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/tools/fleet/fleet_files.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {
namespace {

using fleet_files::Folder;
using geometry::Vector6;
using testing::HasSubstr;

constexpr size_t kMaxFleetBytes = 1 << 20;

ProgramResult fleet(const std::string& arguments) {
  return run_shell_command(programs_folder() + "/infuse fleet " + arguments + " 2>&1");
}

TEST(FleetCommand, EntriesOfDrivesBecomeASummaryAndAPage) {
  const Folder folder;
  const std::string at = folder.path().string() + "/";
  std::string entries;
  for (int day = 1; day <= 3; ++day) {
    const Folder steps;
    const Vector6 moved = day < 3 ? Vector6::Zero() : Vector6(0.01 * Vector6::Unit(2));
    steps.write_step("calibrate", 0, fleet_files::calibrate_output(moved).dump(), "");
    const std::string name = "day" + std::to_string(day);
    const auto made =
        fleet("drive " + steps.path().string() + " --vehicle car --drive " + name +
              " --date 2026-03-0" + std::to_string(day) + " -o " + at + name + ".json");
    ASSERT_EQ(made.code, 0) << made.output;
    entries += at + name + ".json\n";
  }
  folder.write("list", entries);
  folder.write("broken.json", "{");
  const auto pooled = fleet("pool --list " + at + "list " + at + "broken.json -o " + at +
                            "fleet.json --page " + at + "fleet.html");
  ASSERT_EQ(pooled.code, 0) << pooled.output;
  const Json summary =
      Json::parse(text::read_text(at + "fleet.json", kMaxFleetBytes).value_or(""), nullptr, false);
  ASSERT_EQ(summary["vehicles"].size(), 2U);  // an entry that cannot be read is of its folder
  EXPECT_EQ(summary["drives"], 4);
  EXPECT_EQ(summary["failed"][0]["drive"], "broken");
  EXPECT_EQ(summary["vehicles"][0]["verdict"], "drift");
  EXPECT_EQ(summary["vehicles"][0]["cameras"][0]["changes"][0]["begins"], "2026-03-03");
  EXPECT_THAT(text::read_text(at + "fleet.html", kMaxFleetBytes).value_or(""),
              HasSubstr("drift from 2026-03-03 on: rotation about z by +0.57"));
}

TEST(FleetCommand, SaysWhatIsWrong) {
  const Folder folder;
  const std::string at = folder.path().string() + "/";
  folder.write("entry.json", R"({"form":1,"vehicle":"car","drive":"a"})");
  EXPECT_EQ(fleet("pool").code, 2);
  EXPECT_EQ(fleet("pool --significance 2 " + at + "entry.json").code, 2);
  EXPECT_EQ(fleet("pool --rig car " + at + "entry.json").code, 3);
  EXPECT_EQ(fleet("pool --rig car=" + at + "absent.toml " + at + "entry.json").code, 3);
  EXPECT_EQ(fleet("pool " + at + "entry.json -o " + at + "absent/fleet.json").code, 3);
  EXPECT_EQ(fleet("drive " + at + " --vehicle car --drive a -o " + at + "a.json").code, 3);
  const auto date =
      fleet("drive " + at + " --vehicle car --drive a --date monday -o " + at + "a.json");
  EXPECT_EQ(date.code, 2);
  EXPECT_THAT(date.output, HasSubstr("'monday' is not a date such as"));
  EXPECT_EQ(fleet("pool " + at + "entry.json").code, 0);
}

}  // namespace
}  // namespace infuse::daemon
