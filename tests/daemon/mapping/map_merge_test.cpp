// Maps that cannot be merged: nothing of the target is written.

#include "daemon/mapping/map_merge.hpp"

#include <gtest/gtest.h>

#include "tests/daemon/mapping/small_map.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

class MapMerge : public testing::Test {
 protected:
  /// Two maps of five keyframes whose closures are `closures`.
  void write_maps(const std::vector<mapping::Closure>& closures) {
    for (const char* name : {"a", "b"}) {
      write_small_map(folder_ / name, 5, 2);
      ASSERT_TRUE(MapFolder(folder_ / name).write(map_file::kClosures, format_closures(closures)));
    }
  }

  Error refused() {
    const auto merged = merge_maps(MapFolder(folder_ / "both"), {folder_ / "a", folder_ / "b"}, {});
    EXPECT_FALSE(std::filesystem::exists(folder_ / "both"));
    return merged ? Error{} : merged.error();
  }

  ScratchFolder folder_;
};

// Behind the first map's keyframes are those of the second.
TEST_F(MapMerge, AClosureLeadsToAKeyframeOfItsOwnMap) {
  std::vector<mapping::Closure> closures(2);
  closures[0].to = 4;
  closures[1].to = 5 + 3;
  write_maps(closures);
  const Error error = refused();
  EXPECT_EQ(error.what, "a closure of a keyframe that does not exist");
  EXPECT_EQ(error.where, (folder_ / "a/closures.csv").string());
}

TEST_F(MapMerge, AManifestSaysWhatTheMapIsMadeOf) {
  write_maps({});
  const Error error = refused();
  EXPECT_EQ(error.what, "\"sources\" is missing");
  EXPECT_EQ(error.where, (folder_ / "a/map.json").string());
  EXPECT_EQ(error.hint, "make the map anew");
}

}  // namespace
}  // namespace infuse::daemon
