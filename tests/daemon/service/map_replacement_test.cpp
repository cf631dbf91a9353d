#include "daemon/service/map_replacement.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "daemon/service/daemon_host.hpp"
#include "fusion/streetmap/segment_map.hpp"
#include "tests/daemon/mapping/small_map.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

namespace fs = std::filesystem;

class MapReplacementTest : public testing::Test {
 protected:
  void write_street_map(const std::string& provenance) {
    const streetmap::SegmentMapWriter writer({false, 0, 0, 0.2, {0, 0}}, 1, 1);
    const auto bytes = writer.finish(std::vector<streetmap::Segment>(1), provenance).value();
    folder_.write("s", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }

  const ScratchFolder folder_;
  Config config_;
  std::stop_source stop_;
  int uses_ = 0;
};

TEST_F(MapReplacementTest, AStreetMapOfTheSameBytesIsNotAnother) {
  write_street_map("one");
  config_.folder = folder_ / "";
  config_.streetmap.map = "s";
  const std::string first = open_street_map(config_).value().digest;
  const auto look = replace_street_map(
      config_, [this](const StreetMapFile&, const std::stop_token&) { ++uses_; });
  write_street_map("one");
  EXPECT_EQ(look(first, stop_.get_token()), first);
  EXPECT_EQ(uses_, 0);
  write_street_map("two");
  const auto second = look(first, stop_.get_token());
  ASSERT_TRUE(second);
  EXPECT_NE(*second, first);
  EXPECT_EQ(uses_, 1);
  stop_.request_stop();
  look(first, stop_.get_token());
  EXPECT_EQ(uses_, 1);
}

// The same map in another folder is: the folder in use may be gone.
TEST_F(MapReplacementTest, AMapOfKeyframesIsAnotherByItsContentOrItsFolder) {
  write_small_map(folder_ / "map", 3, 2);
  config_.folder = folder_ / "";
  config_.map.directory = "map";
  const OpenedPlaces in_use = open_place_map(config_).value().value();
  const auto look = replace_place_map(
      config_, in_use.folder, [this](const places::PlaceMap&, const std::stop_token&) { ++uses_; });
  fs::last_write_time(folder_ / "map/map.json", fs::file_time_type::clock::now());
  EXPECT_EQ(look(in_use.digest, stop_.get_token()), in_use.digest);
  EXPECT_EQ(uses_, 0);
  fs::copy(folder_ / "map", folder_ / "copy", fs::copy_options::recursive);
  fs::rename(folder_ / "map", folder_ / "before");
  fs::rename(folder_ / "copy", folder_ / "map");
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(look(in_use.digest, stop_.get_token()), in_use.digest);
    EXPECT_EQ(uses_, 1);
  }
}

}  // namespace
}  // namespace infuse::daemon
