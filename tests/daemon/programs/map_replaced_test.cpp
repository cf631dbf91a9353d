// Maps that are overwritten, cut, removed and replaced while infused runs.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/daemon/live_daemon.hpp"
#include "tests/daemon/mapping/small_map.hpp"

namespace infuse::daemon {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// Digest of a map's line in `infuse status`.
std::string digest_in(const std::string& status, const std::string& name) {
  const size_t at = status.find(" " + name + " ");
  return at == std::string::npos ? "" : status.substr(at + name.size() + 2, 16);
}

/// A street map of cells of `cell` m.
void make_street_map(const ScratchFolder& folder, const char* file, const char* cell) {
  const std::string command = programs_folder() + "/infuse streetmap --cell " + cell + " " +
                              source_folder() + "/fixtures/maps/altfeld.osm -o " +
                              (folder / file).string() + " 2>&1";
  const ProgramResult made = run_shell_command(command);
  ASSERT_EQ(made.code, 0) << made.output;
}

void overwrite(const ScratchFolder& folder, const char* from, const char* to) {
  fs::copy_file(folder / from, folder / to, fs::copy_options::overwrite_existing);
}

// Two daemons at a time: each change is seen within some seconds.
TEST(MapReplaced, WhatIsWholeIsUsedAndWhatIsDamagedIsNot) {
  const ScratchFolder streets, keyframes;
  make_street_map(streets, "first.map", "0.5");
  make_street_map(streets, "second.map", "0.8");
  overwrite(streets, "first.map", "in_use.map");
  write_small_map(keyframes / "map", 3, 2);
  LiveDaemon on_streets(streets, "[streetmap]\nmap = \"in_use.map\"\n");
  LiveDaemon on_keyframes(keyframes, "[map]\ndirectory = \"map\"\n");
  const std::string street = digest_in(on_streets.wait_for("streetmap "), "streetmap");
  const std::string map = digest_in(on_keyframes.wait_for(" map "), "map");
  ASSERT_EQ(street.size(), 16U);
  ASSERT_EQ(map.size(), 16U);

  // Another street map, byte by byte; a map with a damaged cloud, by renaming.
  overwrite(streets, "second.map", "in_use.map");
  write_small_map(keyframes / "damaged", 4, 3);
  fs::resize_file(keyframes / "damaged/clouds/000002.pcd.zst", 30);
  fs::rename(keyframes / "map", keyframes / "before");
  fs::rename(keyframes / "damaged", keyframes / "map");
  EXPECT_THAT(on_keyframes.wait_for("WARN  map "),
              AllOf(HasSubstr("WARN  map " + map), HasSubstr("clouds/000002.pcd.zst")));
  std::string next_street = street;
  for (int k = 0; k < 150 && next_street == street; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    next_street = digest_in(on_streets.status(), "streetmap");
  }
  ASSERT_EQ(next_street.size(), 16U);
  EXPECT_NE(next_street, street);

  // Half of a street map; a whole map.
  fs::resize_file(streets / "in_use.map", fs::file_size(streets / "in_use.map") / 2);
  write_small_map(keyframes / "whole", 4, 3);
  fs::remove_all(keyframes / "map");
  fs::rename(keyframes / "whole", keyframes / "map");
  EXPECT_THAT(on_streets.wait_for("WARN  streetmap"),
              AllOf(HasSubstr("WARN  streetmap " + next_street), HasSubstr("is truncated")));
  const std::string status = on_keyframes.wait_for("OK    map ");
  EXPECT_THAT(status, HasSubstr("OK    map "));
  EXPECT_NE(digest_in(status, "map"), map);
  EXPECT_EQ(on_streets.stop(), 0);
  EXPECT_EQ(on_keyframes.stop(), 0);
  EXPECT_THAT(keyframes.read("log"),
              AllOf(HasSubstr(map + " stays in use"), HasSubstr("takes the place of")));
}

}  // namespace
}  // namespace infuse::daemon
