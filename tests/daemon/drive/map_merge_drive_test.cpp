// Maps of several drives are merged, against the simulator's truth.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "daemon/mapping/map_folder.hpp"
#include "daemon/mapping/map_tables.hpp"
#include "tests/daemon/drive/block_map.hpp"
#include "tests/daemon/schema.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

// The other visit goes against the first one; its map has a frame of its own.
TEST_F(BlockMap, AnotherVisitIsMergedIntoTheMap) {
  const std::string other = (made_->folder / "tuesday").string();
  ASSERT_TRUE(simulate(other, visit("[117, 115, 110, 112, 104, 100]", 40)));
  ASSERT_EQ(Made::infuse("map " + other + " --no-gnss -o " + made_->map("of_tuesday")).code, 0);
  const std::string both = made_->map("both");
  const std::string command =
      "map merge " + made_->map() + " " + made_->map("of_tuesday") + " --no-gnss -o " + both;
  const ProgramResult run = Made::infuse(command + " --json");
  ASSERT_EQ(run.code, 0) << run.output;
  EXPECT_TRUE(is_result(run.output, "map"));
  const auto summary = nlohmann::json::parse(run.output);
  EXPECT_EQ(summary["drives"], 2);
  EXPECT_GT(summary["closures"], 20) << run.output;
  std::vector<motion::PosePair> pairs =
      motion::pair_by_time(read_poses(both + "/trajectory.tum"), made_->truth);
  const size_t of_first = pairs.size();
  for (const auto& pair : motion::pair_by_time(read_poses(both + "/trajectory_2.tum"),
                                               read_poses(other + "/truth/poses.tum"))) {
    pairs.push_back(pair);
  }
  EXPECT_GT(pairs.size(), of_first + 50);
  EXPECT_LT(motion::absolute_error(pairs).translation.rms, 0.3);

  // It goes on where it was interrupted, to the same bytes, and is a map as any other.
  const auto expected = bytes_of(both);
  for (const char* last : {"map.json", "drive.json"}) {
    std::filesystem::remove(both + "/" + last);
    EXPECT_EQ(Made::infuse(command).code, 0);
    EXPECT_TRUE(bytes_of(both) == expected) << last;
  }
  const std::string tum = (made_->folder / "second.tum").string();
  EXPECT_EQ(Made::infuse("map export " + both + " --drive 2 -o " + tum).code, 0);
  EXPECT_EQ(read_file(tum), read_file(both + "/trajectory_2.tum"));
  EXPECT_THAT(Made::infuse("map export " + both + " --drive 3 -o " + tum).output,
              HasSubstr("there is no drive 3"));
  EXPECT_THAT(Made::infuse("map merge " + both + " " + made_->map() + " -o " + both).output,
              HasSubstr("merged into itself"));
  EXPECT_EQ(Made::infuse("map merge " + both + " -o " + made_->map("alone")).code, 2);
}

// A map of two drives along one street, of which the slower one has taken over all clouds. Two
// drives and four merges take their time.
TEST_F(BlockMap, AMapWhoseDriveHasNoCloudsIsMergedInEitherOrder) {
  const std::string route = "[110, 112, 104, 100]";
  std::vector<geometry::StampedPose> truth[2];
  for (const int i : {0, 1}) {
    std::string scenario = visit(route, i == 0 ? 18 : 22);
    if (i == 1) {
      scenario.replace(scenario.find("seed = 8"), 8, "seed = 9");
      scenario.replace(scenario.find("speed = 10"), 10, "speed = 8");
    }
    const std::string name = "lap" + std::to_string(i);
    const std::string drive = (made_->folder / name).string();
    ASSERT_TRUE(simulate(drive, scenario));
    ASSERT_EQ(Made::infuse("map " + drive + " --no-gnss -o " + made_->map("of_" + name)).code, 0);
    truth[i] = read_poses(drive + "/truth/poses.tum");
  }
  const auto merge = [](const std::string& a, const std::string& b, const std::string& target) {
    return Made::infuse("map merge " + made_->map(a) + " " + made_->map(b) + " --no-gnss -o " +
                        made_->map(target));
  };
  ProgramResult run = merge("of_lap0", "of_lap1", "laps");
  ASSERT_EQ(run.code, 0) << run.output;
  const MapFolder laps(made_->map("laps"));
  MapJson manifest = laps.read_manifest(map_file::kMap).value();
  std::vector<size_t> kept = manifest[kKeptClouds];
  std::erase_if(kept, [&](size_t k) { return k < manifest[kFirstKeyframes][1]; });
  EXPECT_GE(kept.size() + 5, manifest[kKeptClouds].size()) << "the slower one is newer";
  manifest[kKeptClouds] = kept;
  ASSERT_TRUE(laps.write(map_file::kMap, manifest.dump()));
  laps.keep_clouds(kept);

  for (const bool last : {true, false}) {
    const std::string target = last ? "laps_last" : "laps_first";
    run = last ? merge("map", "laps", target) : merge("laps", "map", target);
    ASSERT_EQ(run.code, 0) << run.output;
    const std::string both = made_->map(target);
    const size_t first_lap = last ? 1 : 0;
    std::vector<motion::PosePair> pairs;
    size_t of_drive[3];
    for (size_t d = 0; d < 3; ++d) {
      const bool is_lap = d >= first_lap && d < first_lap + 2;
      const auto part = motion::pair_by_time(read_poses(both + "/" + MapFolder::trajectory_name(d)),
                                             is_lap ? truth[d - first_lap] : made_->truth);
      of_drive[d] = part.size();
      pairs.insert(pairs.end(), part.begin(), part.end());
    }
    EXPECT_GT(std::min({of_drive[0], of_drive[1], of_drive[2]}), 40U);
    EXPECT_LT(motion::absolute_error(pairs).translation.rms, 0.3);
    // All along the street, not where they join alone.
    const auto map = read_map_drive(MapFolder(both));
    ASSERT_TRUE(map);
    const size_t border = map->first_keyframes[last ? 1 : 2];
    const auto closures = parse_closures(read_file(both + "/closures.csv"), "closures.csv");
    ASSERT_TRUE(closures);
    std::vector<double> ways;
    for (const mapping::Closure& closure : *closures) {
      if (!closure.accepted() || closure.from >= border || closure.to < border) continue;
      ways.push_back(map->keyframes[last ? closure.to : closure.from].keyframe.distance_driven);
    }
    ASSERT_GT(ways.size(), 10U);
    const auto [nearest, farthest] = std::minmax_element(ways.begin(), ways.end());
    EXPECT_GT(*farthest - *nearest, 80) << "of 116 m";
  }
  // And what came of it once more.
  run = merge("laps_last", "of_lap0", "again");
  EXPECT_EQ(run.code, 0) << run.output;
}

TEST_F(BlockMap, MapsWithoutACommonStreetAreNotMerged) {
  const std::string other = (made_->folder / "another_town").string();
  std::string scenario = visit("[100, 104]", 16);
  const size_t begin = scenario.find("map ="), end = scenario.find("build_radius_m");
  scenario.replace(begin, end - begin, "town_size_m = 500\nroute_length_m = 300\n");
  ASSERT_TRUE(simulate(other, scenario));
  ASSERT_EQ(Made::infuse("map " + other + " -o " + made_->map("of_another")).code, 0);
  const ProgramResult run = Made::infuse("map merge " + made_->map() + " " +
                                         made_->map("of_another") + " -o " + made_->map("neither"));
  EXPECT_EQ(run.code, 3);
  EXPECT_THAT(run.output, HasSubstr("drive 2 cannot be joined"));
  EXPECT_FALSE(std::filesystem::exists(made_->map("neither") + "/map.json"));
}

}  // namespace
}  // namespace infuse::daemon
