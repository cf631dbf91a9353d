#include "daemon/mapping/map_folder.hpp"

#include <gtest/gtest.h>

#include <fstream>

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

// `-o ~/scans`, where clouds/ is the user's own.
TEST(MapFolder, CloudsOfOthersAreNotTaken) {
  const ScratchFolder folder;
  for (const char* name : {"street.pcd.zst", "000001.pcd", "7.pcd.zst.bak"}) {
    const fs::path own = folder / "scans/clouds" / name;
    fs::remove_all(folder / "scans");
    fs::create_directories(own.parent_path());
    std::ofstream(own) << "mine";
    const MapFolder scans(folder / "scans");
    const auto refused = scans.create();
    ASSERT_FALSE(refused) << name;
    EXPECT_NE(refused.error().what.find(name), std::string::npos) << refused.error().message();
    scans.keep_clouds({});
    EXPECT_TRUE(fs::exists(own)) << name;
  }
  // What an interrupted run of a map left is gone on with.
  fs::remove_all(folder / "scans");
  for (const char* name : {"000001.pcd.zst", "1000002.pcd.zst", "000003.pcd.zst.a1b2c3"}) {
    fs::create_directories(folder / "scans/clouds");
    std::ofstream(folder / "scans/clouds" / name) << "cloud";
  }
  const MapFolder scans(folder / "scans");
  EXPECT_TRUE(scans.create());
  scans.keep_clouds({1});
  EXPECT_TRUE(fs::exists(folder / "scans/clouds/000001.pcd.zst"));
  EXPECT_FALSE(fs::exists(folder / "scans/clouds/1000002.pcd.zst"));
}

TEST(MapFolder, AnotherVersionIsNamed) {
  const ScratchFolder folder;
  write_small_map(folder / "map", 3, 2);
  const MapFolder map(folder / "map");
  MapJson manifest = map.read_manifest(map_file::kMap).value();
  manifest["version"] = 2;
  ASSERT_TRUE(map.write(map_file::kMap, manifest.dump()));
  const auto read = read_map(map);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().what, "a map of version 2");
  EXPECT_EQ(read.error().hint, "make the map anew with infuse map");
  manifest.erase("version");
  ASSERT_TRUE(map.write(map_file::kMap, manifest.dump()));
  EXPECT_FALSE(read_map(map));
}

}  // namespace
}  // namespace infuse::daemon
