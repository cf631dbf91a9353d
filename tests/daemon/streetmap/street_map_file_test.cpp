#include "daemon/streetmap/street_map_file.hpp"
#include "drivers/measurement/angles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "daemon/streetmap/street_plan_from_osm.hpp"
#include "drivers/gnss/local_frame.hpp"
#include "drivers/recording/atomic_file.hpp"
#include "drivers/text/text_file.hpp"
#include "tests/folders.hpp"
#include "tests/large_extract.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

using streetmap::SegmentKind;
using testing::Contains;
using testing::HasSubstr;

/// OpenStreetMap XML of nodes on a grid of about 10 m: node 100·row + column.
std::string map_text(const std::string& ways) {
  std::ostringstream text;
  text.precision(12);
  text << "<osm version='0.6'>";
  for (int row = 0; row < 10; ++row) {
    for (int column = 0; column < 10; ++column) {
      text << "<node id='" << 100 * row + column + 1 << "' version='1' lat='" << 50 + row * 9e-5
           << "' lon='" << 8 + column * 1.4e-4 << "'/>";
    }
  }
  text << "<node id='5000' version='1' lat='10' lon='8'/>";
  text << ways << "</osm>";
  return text.str();
}

std::string way(int id, const std::vector<int>& nodes, const std::string& tags) {
  std::ostringstream text;
  text << "<way id='" << id << "' version='1'>";
  for (const int node : nodes) text << "<nd ref='" << node << "'/>";
  std::istringstream words(tags);
  for (std::string word; words >> word;) {
    const size_t equals = word.find('=');
    text << "<tag k='" << word.substr(0, equals) << "' v='" << word.substr(equals + 1) << "'/>";
  }
  text << "</way>";
  return text.str();
}

class StreetMapFileTest : public testing::Test {
 protected:
  Result<GeneratedStreetMap> make(const std::string& ways) {
    const auto path = folder_ / "map.osm";
    EXPECT_TRUE(text::write_text(path, map_text(ways)));
    return make_street_map(path, {});
  }
  std::vector<std::string> warnings(const std::string& ways) {
    std::vector<std::string> list;
    const auto made = make(way(1, {1, 10}, "highway=residential") + ways);
    EXPECT_TRUE(made);
    if (!made) return list;
    for (const Error& warning : made->warnings) list.push_back(warning.message());
    return list;
  }
  streetmap::PlanStrip strip(const std::string& tags) {
    const auto path = folder_ / "strip.osm";
    EXPECT_TRUE(text::write_text(path, map_text(way(1, {1, 10}, tags))));
    const auto map = osm::read_openstreetmap(path);
    EXPECT_TRUE(map);
    const auto planned = build_street_plan(*map);
    return planned.plan.strips.empty() ? streetmap::PlanStrip{} : planned.plan.strips[0];
  }
  double width(const std::string& tags) { return 2 * strip(tags).half_width; }
  ScratchFolder folder_;
};

TEST_F(StreetMapFileTest, WidthsComeFromTheTagElseLanesElseClass) {
  EXPECT_DOUBLE_EQ(width("highway=residential width=4.2"), 4.2);
  EXPECT_DOUBLE_EQ(width("highway=primary lanes=3"), 10.5);
  EXPECT_DOUBLE_EQ(width("highway=residential"), 6);
  EXPECT_DOUBLE_EQ(width("highway=residential oneway=yes"), 5.5);
  EXPECT_DOUBLE_EQ(width("highway=residential width=wide"), 6);
  EXPECT_DOUBLE_EQ(width("highway=residential width=20ft"), 6.096);
  EXPECT_DOUBLE_EQ(width("highway=residential width=4,2"), 4.2);
  EXPECT_DOUBLE_EQ(width("highway=residential lanes=-3"), 6);
  EXPECT_DOUBLE_EQ(width("highway=proposed"), 0);
}

TEST_F(StreetMapFileTest, PavementsAreDrawnOnlyWithASidewalkTag) {
  const struct {
    const char* tags;
    bool left, right;
  } expected[] = {{"", false, false},
                  {"sidewalk=no", false, false},
                  {"sidewalk=separate", false, false},
                  {"sidewalk=both", true, true},
                  {"sidewalk=right", false, true},
                  {"sidewalk=left", true, false},
                  {"sidewalk:both=yes", true, true},
                  {"sidewalk:left=yes", true, false},
                  {"sidewalk:both=separate sidewalk:right=yes", false, true},
                  {"sidewalk=both sidewalk:left=separate", false, true}};
  for (const auto& [tags, left, right] : expected) {
    const auto street = strip(std::string("highway=residential ") + tags);
    EXPECT_EQ(street.left_sidewalk_width > 1, left) << tags;
    EXPECT_EQ(street.right_sidewalk_width > 1, right) << tags;
  }
  EXPECT_GT(strip("highway=residential").kerb_width, 0);
}

TEST_F(StreetMapFileTest, BridgesAndCuttingsHaveTheirLayer) {
  EXPECT_EQ(strip("highway=residential").layer, 0);
  EXPECT_EQ(strip("highway=residential bridge=yes").layer, 1);
  EXPECT_EQ(strip("highway=residential bridge=viaduct layer=2").layer, 2);
  EXPECT_EQ(strip("highway=residential bridge=no layer=1").layer, 0);
  EXPECT_EQ(strip("highway=residential layer=-1").layer, -1);
  EXPECT_EQ(strip("highway=residential layer=high").layer, 0);
}

TEST_F(StreetMapFileTest, TunnelsAreStreetsBelowGround) {
  EXPECT_FALSE(strip("highway=residential tunnel=no").tunnel);
  EXPECT_TRUE(strip("highway=residential tunnel=yes").tunnel);
  EXPECT_TRUE(strip("highway=service tunnel=building_passage").tunnel);
  EXPECT_TRUE(strip("highway=footway tunnel=yes").points.empty());
}

TEST_F(StreetMapFileTest, OpenAndSelfCrossingRingsAreReportedWithTheirId) {
  EXPECT_THAT(warnings(way(77, {101, 102, 203}, "building=yes")),
              Contains("way 77: is an area that does not close (it is skipped)"));
  EXPECT_THAT(warnings(way(78, {301, 404, 304, 401, 301}, "leisure=park")),
              Contains("way 78: has a ring that crosses itself (it is skipped)"));
  EXPECT_THAT(warnings(way(79, {301, 5000}, "highway=service")),
              Contains("way 79: lies more than 50 km from the rest of the map (it is skipped)"));
  EXPECT_THAT(warnings(way(80, {301, 9999, 302}, "highway=service")),
              Contains(HasSubstr("way 80: 1 of its nodes are not in the file")));
  EXPECT_THAT(warnings(way(81, {301, 304, 404, 401, 301}, "building=yes")), testing::IsEmpty());
}

TEST_F(StreetMapFileTest, WarningsOfAKindAreCounted) {
  std::string ways;
  for (int id = 100; id < 500; ++id) ways += way(id, {101, 102, 203}, "building=yes");
  ways += way(80, {301, 9999, 302}, "highway=service");
  const std::vector<std::string> list = warnings(ways);
  ASSERT_EQ(list.size(), 4U);
  EXPECT_THAT(list,
              Contains(HasSubstr("way 102: is an area that does not close; 397 more like this")));
  EXPECT_THAT(list, Contains(HasSubstr("way 80: 1 of its nodes are not in the file")));
}

TEST_F(StreetMapFileTest, AMapWithoutRoadsIsRejected) {
  for (const char* tags : {"building=yes", "highway=footway"}) {
    const auto made = make(way(1, {1, 4, 304, 301, 1}, tags));
    ASSERT_FALSE(made) << tags;
    EXPECT_THAT(made.error().message(), HasSubstr("has no drivable road"));
  }
}

TEST_F(StreetMapFileTest, OpensAGeneratedMap) {
  const auto made = make(way(4711, {1, 10}, "highway=residential"));
  ASSERT_TRUE(made);
  const auto path = folder_ / "a.map";
  ASSERT_TRUE(recording::write_file_atomically(path, made->bytes));
  auto opened = open_street_map_file(path);
  ASSERT_TRUE(opened) << opened.error().message();
  const StreetMapFile moved = std::move(*opened);  // the map stays valid
  const auto& frame = moved.map.frame();
  const auto local = gnss::make_local_frame(frame.latitude, frame.longitude);
  const auto middle = gnss::to_local(local, 50 * kDegree, 8.0006 * kDegree);
  const auto segment = moved.map.segment(moved.map.id_at(middle.x(), middle.y()));
  EXPECT_EQ(segment.kind, SegmentKind::kCarriageway);
  EXPECT_EQ(segment.osm_id, 4711);
  EXPECT_THAT(std::string(moved.map.provenance()), HasSubstr("map.osm"));
}

// A memory-mapped file would end the process.
TEST_F(StreetMapFileTest, AFileThatIsCutOrOverwrittenLaterChangesNothing) {
  const auto made = make(way(4711, {1, 10}, "highway=residential"));
  ASSERT_TRUE(made);
  const auto path = folder_ / "a.map";
  ASSERT_TRUE(recording::write_file_atomically(path, made->bytes));
  const auto opened = open_street_map_file(path);
  ASSERT_TRUE(opened);
  const auto count_streets = [&] {
    int count = 0;
    const streetmap::SegmentMap& map = opened->map;
    for (int row = 0; row < map.rows(); ++row) {
      for (int column = 0; column < map.columns(); ++column) {
        count += map.id_of_cell(column, row) != 0 ? 1 : 0;
      }
    }
    return count;
  };
  const int streets = count_streets();
  EXPECT_GT(streets, 0);
  ASSERT_TRUE(text::write_text(path, std::string(made->bytes.size(), 'x')));
  EXPECT_EQ(count_streets(), streets);
  std::filesystem::resize_file(path, 0);
  EXPECT_EQ(count_streets(), streets);
}

TEST_F(StreetMapFileTest, DamagedFilesAreReported) {
  const auto made = make(way(4711, {1, 10}, "highway=residential"));
  ASSERT_TRUE(made);
  const auto path = folder_ / "cut.map";
  ASSERT_TRUE(
      recording::write_file_atomically(path, std::span(made->bytes).first(made->bytes.size() / 2)));
  const auto cut = open_street_map_file(path);
  ASSERT_FALSE(cut);
  EXPECT_THAT(cut.error().message(), HasSubstr("is truncated"));
  EXPECT_FALSE(open_street_map_file(folder_ / "missing.map"));
  EXPECT_FALSE(open_street_map_file("/"));
  ASSERT_TRUE(text::write_text(folder_ / "empty.map", ""));
  EXPECT_FALSE(open_street_map_file(folder_ / "empty.map"));
  ASSERT_TRUE(text::write_text(folder_ / "text.map", std::string(500, 'x')));
  const auto text = open_street_map_file(folder_ / "text.map");
  ASSERT_FALSE(text);
  EXPECT_THAT(text.error().message(), HasSubstr("is not an infuse street map"));
}

// More than there is memory, none of which is on the disk: neither is read.
TEST_F(StreetMapFileTest, AHugeFileIsRefusedByItsHeader) {
  const auto made = make(way(4711, {1, 10}, "highway=residential"));
  ASSERT_TRUE(made);
  const auto path = folder_ / "huge.map";
  constexpr uintmax_t kHuge = uintmax_t{1} << 40;
  for (const bool header : {false, true}) {
    ASSERT_TRUE(
        recording::write_file_atomically(path, std::span(made->bytes).first(header ? 96 : 0)));
    std::filesystem::resize_file(path, kHuge);
    const auto opened = open_street_map_file(path);
    ASSERT_FALSE(opened);
    EXPECT_THAT(opened.error().message(),
                HasSubstr(header ? "has bytes after its end" : "is not an infuse street map"));
  }
}

TEST_F(StreetMapFileTest, AnImageNeedsAScale) {
  const auto made = make_street_map("screenshot.png", {});
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message(), HasSubstr("no scale"));
}

TEST(StreetMap, AltfeldConvertsWithoutWarnings) {
  const auto made = make_street_map(source_folder() + "/fixtures/maps/altfeld.osm", {});
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_THAT(made->warnings, testing::IsEmpty());
}

TEST_F(StreetMapFileTest, AWoodOverALargeExtractCostsNothing) {
  const auto small = text::read_text(source_folder() + "/fixtures/maps/altfeld.osm", 1 << 20);
  ASSERT_TRUE(small);
  const auto path = folder_ / "large.osm";
  size_t bytes[2] = {};
  for (const bool wood : {false, true}) {  // the wood: 0.18 of 0.3 degrees
    ASSERT_TRUE(text::write_text(path, large_extract(*small, 2, 0.3, 49.99, 8.49, wood)));
    const auto made = make_street_map(path, {});
    ASSERT_TRUE(made) << made.error().message();
    bytes[wood ? 1 : 0] = made->bytes.size();
    const auto map = streetmap::SegmentMap::open(made->bytes, "map");
    ASSERT_TRUE(map);
    EXPECT_GT(map->columns() * map->frame().cell_size, 9000);
  }
  EXPECT_LT(bytes[1], bytes[0] * 5 / 4);
  EXPECT_LT(bytes[1], 6'000'000U);
}

TEST_F(StreetMapFileTest, ClipAndBoundsLimitWhatIsUsed) {
  const auto path = folder_ / "map.osm";
  const std::string ways = way(1, {1, 10}, "highway=residential") +
                           way(2, {501, 510}, "highway=residential") +
                           way(3, {901, 910}, "highway=residential");
  const std::string whole = map_text(ways);
  const auto names = [](const OsmStreetPlan& planned) {
    std::vector<int64_t> ids;
    for (const auto& strip : planned.plan.strips) ids.push_back(strip.segment.osm_id);
    return ids;
  };
  const auto plan = [&](const std::string& bounds, const std::optional<osm::Bounds>& clip) {
    std::string text = whole;
    text.insert(text.find("<node"), bounds);
    EXPECT_TRUE(text::write_text(path, text));
    return build_street_plan(*osm::read_openstreetmap(path), clip);
  };
  const osm::Bounds south{49.9999 * kDegree, 7.99 * kDegree, 50.0001 * kDegree, 8.01 * kDegree};
  const auto clipped = plan("", south);
  EXPECT_THAT(names(clipped), testing::ElementsAre(1));
  EXPECT_NEAR(clipped.plan.latitude, 50 * kDegree, 1e-9);
  EXPECT_NEAR(clipped.plan.limit.sizes().y(), 2e-4 * kDegree * 6.37e6, 0.2);
  // A hundred metres around the bounds of a file are used too; rows are ten metres apart.
  const char* const far_south =
      "<bounds minlat='49.99' minlon='7.99' maxlat='49.9996' maxlon='8.01'/>";
  const auto bounded = plan(far_south, {});
  EXPECT_THAT(names(bounded), testing::ElementsAre(1, 2));
  EXPECT_NEAR(bounded.plan.latitude, 49.9948 * kDegree, 1e-9);
  EXPECT_NEAR(bounded.plan.longitude, 8 * kDegree, 1e-9);
  const char* const elsewhere = "<bounds minlat='1' minlon='1' maxlat='2' maxlon='2'/>";
  const auto ignored = plan(elsewhere, {});
  EXPECT_EQ(ignored.plan.strips.size(), 3U);
  ASSERT_FALSE(ignored.warnings.empty());
  EXPECT_THAT(ignored.warnings.back().message(), HasSubstr("no road within its bounds"));
  const auto nothing = make_street_map(path, {.clip = osm::Bounds{0, 0, 0.1, 0.1}});
  ASSERT_FALSE(nothing);
  EXPECT_THAT(nothing.error().message(), HasSubstr("no drivable road within --clip"));
}

/// Share of the rows of a drive on carriageways, and the maximum distance from them, m.
struct RoadCoverage {
  double share = 0;
  double max_distance = 0;
};

RoadCoverage measure_road_coverage(const std::filesystem::path& osm,
                                   const std::filesystem::path& rows) {
  RoadCoverage result;
  const auto made = make_street_map(osm, {});
  EXPECT_TRUE(made);
  const auto unpacked = testing::TempDir() + "/oxts.txt";
  EXPECT_EQ(std::system(("bzcat " + rows.string() + " > " + unpacked).c_str()), 0);
  const auto text = text::read_text(unpacked, 1 << 27);
  std::filesystem::remove(unpacked);
  const auto map = made ? streetmap::SegmentMap::open(made->bytes, "map")
                        : Result<streetmap::SegmentMap>(tl::unexpected(made.error()));
  EXPECT_TRUE(map && text);
  if (!map || !text) return result;
  const auto frame = gnss::make_local_frame(map->frame().latitude, map->frame().longitude);
  const auto driven = [&](double x, double y) {
    const SegmentKind kind = map->segment(map->id_at(x, y)).kind;
    return kind == SegmentKind::kCarriageway || kind == SegmentKind::kCrossing;
  };
  std::istringstream lines(*text);
  double count = 0, on = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    std::istringstream words(line);
    double latitude = 0, longitude = 0;
    words >> latitude >> longitude;
    const Eigen::Vector3d p = gnss::to_local(frame, latitude * kDegree, longitude * kDegree);
    if (driven(p.x(), p.y())) {
      ++on;
      continue;
    }
    double nearest = 1e9;
    for (double r = 0.1; r < 10 && nearest > 1e8; r += 0.1) {
      for (double a = 0; a < 6.28; a += 0.1) {
        if (driven(p.x() + r * std::cos(a), p.y() + r * std::sin(a))) nearest = r;
      }
    }
    result.max_distance = std::max(result.max_distance, nearest);
  }
  result.share = on / count;
  return result;
}

TEST(StreetMap, RealKarlsruheTrajectoriesLieOnCarriageways) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "street");
  const struct {
    const char* sequence;
    double share;
  } expected[] = {{"00", 0.97}, {"05", 0.90}, {"07", 0.97}};
  for (const auto& [sequence, share] : expected) {
    const RoadCoverage found = measure_road_coverage(folder / (std::string(sequence) + ".osm.bz2"),
                                                     folder / (std::string(sequence) + ".txt.bz2"));
    EXPECT_GE(found.share, share) << sequence;
    EXPECT_LE(found.max_distance, 3.5) << sequence;
    RecordProperty(std::string("share_") + sequence, std::to_string(found.share));
  }
}

}  // namespace
}  // namespace infuse::daemon
