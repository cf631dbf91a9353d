#include "daemon/mapping/map_folder.hpp"

#include <gtest/gtest.h>

#include "tests/daemon/mapping/small_map.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

namespace fs = std::filesystem;

TEST(MapFolder, WhatIsHeldIsReadWhateverTakesItsName) {
  const ScratchFolder folder;
  write_small_map(folder / "map", 3, 2);
  const auto held = MapFolder(folder / "map").hold();
  ASSERT_TRUE(held);
  const auto map = open_place_map(*held);
  ASSERT_TRUE(map) << map.error().message();
  EXPECT_EQ(map->T_map_vehicle.size(), 3U);
  fs::rename(folder / "map", folder / "before");
  write_small_map(folder / "map", 4, 5);
  EXPECT_TRUE(check_clouds(*map));
  EXPECT_EQ(map->read_cloud(2)->x[1], 2);
  const auto next = MapFolder(folder / "map").hold();
  ASSERT_TRUE(next);
  EXPECT_NE(map_digest(*held).value(), map_digest(*next).value());
  EXPECT_EQ(open_place_map(*next)->read_cloud(3)->x[1], 5);
  EXPECT_FALSE(MapFolder(folder / "missing").hold());
}

TEST(MapFolder, ACloudThatIsOverwrittenIsAnErrorWithItsName) {
  const ScratchFolder folder;
  write_small_map(folder / "map", 3, 2);
  const auto map = open_place_map(*MapFolder(folder / "map").hold());
  ASSERT_TRUE(map);
  fs::resize_file(folder / "map/clouds/000001.pcd.zst", 40);
  EXPECT_TRUE(map->read_cloud(0));
  const auto cut = map->read_cloud(1);
  ASSERT_FALSE(cut);
  EXPECT_EQ(cut.error().where, (folder / "map/clouds/000001.pcd.zst").string());
  fs::remove_all(folder / "map");
  EXPECT_FALSE(map->read_cloud(0));
}

TEST(MapFolder, PlacesAreTheKeyframesThatKeepTheirClouds) {
  const ScratchFolder folder;
  write_small_map(folder / "map", 5, 2, {1, 4});
  EXPECT_FALSE(fs::exists(folder / "map/clouds/000003.pcd.zst"));
  const auto map = open_place_map(MapFolder(folder / "map"));
  ASSERT_TRUE(map) << map.error().message();
  ASSERT_EQ(map->T_map_vehicle.size(), 2U);
  EXPECT_EQ(map->T_map_vehicle[1].translation().x(), 8);
  EXPECT_EQ(map->descriptors.size(), 2U);
  EXPECT_TRUE(check_clouds(*map));
  const auto content = read_map(MapFolder(folder / "map"));
  ASSERT_TRUE(content);
  EXPECT_EQ(content->T_map_vehicle.size(), 5U);
  EXPECT_FALSE(content->drive.keyframes[3].keyframe.has_cloud);
  EXPECT_EQ(content->drive.keyframes[4].points, 2U);
  for (const std::vector<size_t>& wrong : {std::vector<size_t>{4, 1}, {2, 5}, {3, 3}}) {
    write_small_map(folder / "wrong", 5, 2, wrong);
    EXPECT_FALSE(open_place_map(MapFolder(folder / "wrong")));
  }
}

}  // namespace
}  // namespace infuse::daemon
