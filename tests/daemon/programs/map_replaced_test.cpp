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

TEST(MapReplaced, AStreetMapThatIsOverwrittenOrCutDoesNotEndTheDaemon) {
  const ScratchFolder folder;
  make_street_map(folder, "first.map", "0.5");
  make_street_map(folder, "second.map", "0.8");
  overwrite(folder, "first.map", "in_use.map");
  LiveDaemon daemon(folder, "[streetmap]\nmap = \"in_use.map\"\n");
  const std::string first = digest_in(daemon.wait_for("streetmap "), "streetmap");
  ASSERT_EQ(first.size(), 16U);
  overwrite(folder, "second.map", "in_use.map");  // its bytes, in place
  std::string second, status;
  for (int k = 0; k < 150 && (second.empty() || second == first); ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    status = daemon.status();
    second = digest_in(status, "streetmap");
  }
  EXPECT_NE(second, first);
  EXPECT_THAT(status, HasSubstr("OK    streetmap " + second));
  fs::resize_file(folder / "in_use.map", fs::file_size(folder / "in_use.map") / 2);
  EXPECT_THAT(daemon.wait_for("WARN  streetmap"),
              AllOf(HasSubstr("WARN  streetmap " + second), HasSubstr("is truncated")));
  EXPECT_EQ(daemon.stop(), 0);
}

TEST(MapReplaced, AMapOfKeyframesIsTakenOverWhole) {
  const ScratchFolder folder;
  write_small_map(folder / "map", 3, 2);
  LiveDaemon daemon(folder, "[map]\ndirectory = \"map\"\n");
  const std::string first = digest_in(daemon.wait_for(" map "), "map");
  ASSERT_EQ(first.size(), 16U);
  // One with a damaged cloud, then a whole one, each put in place by renaming.
  write_small_map(folder / "damaged", 4, 3);
  fs::resize_file(folder / "damaged/clouds/000002.pcd", 30);
  fs::rename(folder / "map", folder / "before");
  fs::rename(folder / "damaged", folder / "map");
  EXPECT_THAT(daemon.wait_for("WARN  map "),
              AllOf(HasSubstr("WARN  map " + first), HasSubstr("clouds/000002.pcd")));
  write_small_map(folder / "whole", 4, 3);
  fs::remove_all(folder / "map");
  fs::rename(folder / "whole", folder / "map");
  const std::string status = daemon.wait_for("OK    map ");
  EXPECT_THAT(status, HasSubstr("OK    map "));
  EXPECT_NE(digest_in(status, "map"), first);
  EXPECT_EQ(daemon.stop(), 0);
  EXPECT_THAT(folder.read("log"),
              AllOf(HasSubstr("map " + first + " stays in use"), HasSubstr("takes the place of")));
}

}  // namespace
}  // namespace infuse::daemon
