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
  fs::resize_file(folder / "map/clouds/000001.pcd", 40);
  EXPECT_TRUE(map->read_cloud(0));
  const auto cut = map->read_cloud(1);
  ASSERT_FALSE(cut);
  EXPECT_EQ(cut.error().where, (folder / "map/clouds/000001.pcd").string());
  fs::remove_all(folder / "map");
  EXPECT_FALSE(map->read_cloud(0));
}

}  // namespace
}  // namespace infuse::daemon
