#include "drivers/osm/openstreetmap.hpp"
#include "drivers/measurement/angles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <osmium/io/pbf_output.hpp>
#include <osmium/io/reader.hpp>
#include <osmium/io/writer.hpp>
#include <osmium/io/xml_input.hpp>

#include "drivers/gnss/local_frame.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::osm {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A road, a footway with a missing node, a tree, and a building with a courtyard whose outer ring
// consists of two ways of opposite direction. The ways precede the nodes.
const char* const kMap = R"(<?xml version='1.0' encoding='UTF-8'?>
<osm version='0.6'>
  <way id='100'>
    <nd ref='1'/><nd ref='2'/><nd ref='3'/>
    <tag k='highway' v='residential'/><tag k='width' v='6.5'/><tag k='name' v='Süd &amp; Nord'/>
  </way>
  <way id='101'><nd ref='3'/><nd ref='99'/><nd ref='4'/><tag k='highway' v='footway'/></way>
  <way id='102'><nd ref='10'/><nd ref='11'/><nd ref='12'/></way>
  <way id='103'><nd ref='10'/><nd ref='13'/><nd ref='12'/></way>
  <way id='104'><nd ref='14'/><nd ref='15'/><nd ref='16'/><nd ref='14'/></way>
  <way id='105'><nd ref='98'/><nd ref='1'/></way>
  <relation id='200'>
    <member type='way' ref='102' role='outer'/>
    <member type='way' ref='103' role=''/>
    <member type='way' ref='104' role='inner'/>
    <tag k='type' v='multipolygon'/><tag k='building' v='yes'/>
  </relation>
  <relation id='201'>
    <member type='way' ref='102' role='outer'/>
    <member type='way' ref='999' role='outer'/>
    <tag k='type' v='multipolygon'/>
  </relation>
  <relation id='202'><member type='way' ref='100' role=''/><tag k='type' v='route'/></relation>
  <node id='1' lat='49.0' lon='8.0'/>
  <node id='2' lat='49.001' lon='8.0'/>
  <node id='3' lat='49.001' lon='8.002'/>
  <node id='4' lat='49.002' lon='8.002'/>
  <node id='5' lat='49.0005' lon='8.0001'><tag k='natural' v='tree'/></node>
  <node id='6' lat='149.0' lon='8.0'/>
  <node id='10' lat='49.0001' lon='8.0010'/>
  <node id='11' lat='49.0001' lon='8.0014'/>
  <node id='12' lat='49.0004' lon='8.0014'/>
  <node id='13' lat='49.0004' lon='8.0010'/>
  <node id='14' lat='49.0002' lon='8.0011'/>
  <node id='15' lat='49.0002' lon='8.0012'/>
  <node id='16' lat='49.0003' lon='8.0012'/>
</osm>
)";

std::vector<int64_t> node_ids(const std::vector<Point>& points) {
  std::vector<int64_t> result;
  for (const Point& point : points) result.push_back(point.node);
  return result;
}

std::string join_messages(const std::vector<Error>& warnings) {
  std::string text;
  for (const Error& warning : warnings) text += warning.message() + "\n";
  return text;
}

TEST(OpenStreetMap, ANumberOfATagIsTheLeadingOneWithinLimits) {
  const std::vector<Tag> tags = {{"width", "6.5 m"}, {"lanes", "many"}, {"height", "1e9"}};
  EXPECT_EQ(find_number(tags, "width", 1, 10), 6.5);
  EXPECT_EQ(find_number(tags, "width", 7, 10), std::nullopt);
  EXPECT_EQ(find_number(tags, "lanes", 0, 10), std::nullopt);
  EXPECT_EQ(find_number(tags, "height", 0, 300), std::nullopt);
  EXPECT_EQ(find_number(tags, "layer", -5, 5), std::nullopt);
}

TEST(OpenStreetMap, ALengthHasUnitsAndADecimalPointOrComma) {
  const auto length = [](const char* text) {
    return find_length({{"width", text}}, "width", 0.5, 60);
  };
  for (const char* text : {"3.5", "3,5", "3.5 m", "3.5m", "350 cm", "0.0035 km"}) {
    ASSERT_TRUE(length(text)) << text;
    EXPECT_NEAR(*length(text), 3.5, 1e-12) << text;
  }
  for (const char* text : {"20'", "20 ft", "20 feet", "20'0\""}) {
    ASSERT_TRUE(length(text)) << text;
    EXPECT_NEAR(*length(text), 6.096, 1e-12) << text;
  }
  EXPECT_NEAR(*length("6'6\""), 1.9812, 1e-12);
  for (const char* text :
       {"", "wide", "3;4", "~3", "3 lanes", "nan", "1e9", "0.1", "6'x\"", "6'\""}) {
    EXPECT_FALSE(length(text)) << text;
  }
}

// A map of two nodes and a residential way, as libosmium and protozero write it.
TEST(OpenStreetMap, ReadsTheBinaryFormAsTheText) {
  const ScratchFolder folder;
  folder.write("map.osm", kMap);
  const osmium::io::File text((folder / "map.osm").string());
  osmium::io::Reader reader(text);
  osmium::io::Writer writer(
      osmium::io::File((folder / "map.osm.pbf").string(), "pbf,pbf_compression=none"));
  while (osmium::memory::Buffer buffer = reader.read()) writer(std::move(buffer));
  writer.close();
  reader.close();
  const auto expected = read_openstreetmap(folder / "map.osm");
  const auto map = read_openstreetmap(folder / "map.osm.pbf");
  ASSERT_TRUE(expected);
  ASSERT_TRUE(map) << map.error().message();
  ASSERT_EQ(map->ways.size(), expected->ways.size());
  for (size_t i = 0; i < map->ways.size(); ++i) {
    EXPECT_EQ(map->ways[i].id, expected->ways[i].id);
    EXPECT_EQ(node_ids(map->ways[i].points), node_ids(expected->ways[i].points));
    EXPECT_EQ(map->ways[i].tags.size(), expected->ways[i].tags.size());
  }
  EXPECT_EQ(map->areas.size(), expected->areas.size());
  EXPECT_EQ(map->centre_latitude, expected->centre_latitude);
  // Damaged files are errors.
  std::string bytes = folder.read("map.osm.pbf");
  folder.write("short.osm.pbf", bytes.substr(0, bytes.size() / 2));
  EXPECT_FALSE(read_openstreetmap(folder / "short.osm.pbf"));
  for (size_t at = 0; at < bytes.size(); at += 7) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    folder.write("damaged.osm.pbf", damaged);
    (void)read_openstreetmap(folder / "damaged.osm.pbf");  // must return
  }
  // A NUL in a text; the sanitizers see a reader that leaves the list of tags.
  const size_t key = bytes.find("highway");
  ASSERT_NE(key, std::string::npos);
  bytes[key + 3] = '\0';
  folder.write("nul.osm.pbf", bytes);
  (void)read_openstreetmap(folder / "nul.osm.pbf");
}

TEST(OpenStreetMap, ReadsWaysNodesAndAreas) {
  const ScratchFolder folder;
  folder.write("map.osm", kMap);
  const auto map = read_openstreetmap(folder / "map.osm");
  ASSERT_TRUE(map) << map.error().message();

  ASSERT_EQ(map->ways.size(), 5u);
  EXPECT_EQ(map->ways[0].id, 100);
  EXPECT_EQ(find_tag(map->ways[0].tags, "highway"), "residential");
  EXPECT_EQ(find_tag(map->ways[0].tags, "width"), "6.5");
  EXPECT_EQ(find_tag(map->ways[0].tags, "name"), "Süd & Nord");
  EXPECT_EQ(find_tag(map->ways[0].tags, "lanes"), "");
  EXPECT_THAT(node_ids(map->ways[0].points), ElementsAre(1, 2, 3));
  EXPECT_NEAR(map->ways[0].points[2].latitude, 49.001 * kDegree, 1e-12);
  EXPECT_NEAR(map->ways[0].points[2].longitude, 8.002 * kDegree, 1e-12);
  EXPECT_FALSE(map->ways[0].closed());
  EXPECT_THAT(node_ids(map->ways[1].points), ElementsAre(3, 4));
  EXPECT_TRUE(map->ways[4].closed());

  ASSERT_EQ(map->nodes.size(), 1u);
  EXPECT_EQ(map->nodes[0].id, 5);
  EXPECT_EQ(find_tag(map->nodes[0].tags, "natural"), "tree");

  ASSERT_EQ(map->areas.size(), 1u);
  EXPECT_EQ(map->areas[0].id, 200);
  EXPECT_EQ(find_tag(map->areas[0].tags, "building"), "yes");
  ASSERT_EQ(map->areas[0].outer.size(), 1u);
  EXPECT_THAT(node_ids(map->areas[0].outer[0]), ElementsAre(10, 11, 12, 13, 10));
  ASSERT_EQ(map->areas[0].inner.size(), 1u);
  EXPECT_THAT(node_ids(map->areas[0].inner[0]), ElementsAre(14, 15, 16, 14));

  EXPECT_NEAR(map->centre_latitude, 49.001 * kDegree, 1e-12);
  EXPECT_NEAR(map->centre_longitude, 8.001 * kDegree, 1e-12);

  const std::string warnings = join_messages(map->warnings);
  EXPECT_THAT(warnings, HasSubstr("way 101: 1 of its nodes are not in the file"));
  EXPECT_THAT(warnings, HasSubstr("way 105: has fewer than two nodes"));
  EXPECT_THAT(warnings, HasSubstr("relation 201: way 999 is not in the file"));
  EXPECT_THAT(warnings, HasSubstr("relation 201: 1 of its rings do not close"));
  EXPECT_THAT(warnings, HasSubstr("relation 201: has no closed outer ring"));
  EXPECT_THAT(warnings, HasSubstr("node 6: has no valid latitude"));
}

TEST(OpenStreetMap, RejectsInvalidFilesAndWarnsAboutEmptyMaps) {
  const ScratchFolder folder;
  EXPECT_FALSE(read_openstreetmap(folder / "missing.osm"));
  EXPECT_FALSE(read_openstreetmap(folder.path()));
  folder.write("broken.osm", std::string(kMap).substr(0, 700));
  EXPECT_THAT(read_openstreetmap(folder / "broken.osm").error().message(), HasSubstr("broken.osm"));
  folder.write("text.osm", "hello");
  EXPECT_FALSE(read_openstreetmap(folder / "text.osm"));
  folder.write("broken.osm.bz2", "BZh91AY&SY rubbish");
  EXPECT_FALSE(read_openstreetmap(folder / "broken.osm.bz2"));
  folder.write("map.xyz", kMap);
  EXPECT_FALSE(read_openstreetmap(folder / "map.xyz"));
  folder.write("empty.osm", "<osm version='0.6'></osm>");
  const auto empty = read_openstreetmap(folder / "empty.osm");
  ASSERT_TRUE(empty);
  EXPECT_THAT(join_messages(empty->warnings), HasSubstr("the map has no road"));
  folder.write("map.osm", kMap);
  OpenStreetMapOptions small;
  small.max_elements = 20;
  EXPECT_THAT(read_openstreetmap(folder / "map.osm", small).error().message(),
              HasSubstr("more than 20 elements"));
}

// Extracts across that meridian go on beyond 180 degrees.
TEST(OpenStreetMap, KeepsNodesBeyondTheMeridianOf180Degrees) {
  const ScratchFolder folder;
  folder.write("fiji.osm",
               "<osm version='0.6'><node id='1' version='1' lat='-16.8' lon='179.999'/>"
               "<node id='2' version='1' lat='-16.8' lon='180.001'/>"
               "<way id='3' version='1'><nd ref='1'/><nd ref='2'/><tag k='highway' v='road'/></way>"
               "</osm>");
  const auto map = read_openstreetmap(folder / "fiji.osm");
  ASSERT_TRUE(map) << map.error().message();
  EXPECT_TRUE(map->warnings.empty()) << join_messages(map->warnings);
  ASSERT_EQ(map->ways.size(), 1u);
  ASSERT_EQ(map->ways[0].points.size(), 2u);
  EXPECT_NEAR(map->ways[0].points[1].longitude, 180.001 * kDegree, 1e-9);
  EXPECT_NEAR(map->centre_longitude, 180 * kDegree, 1e-9);
}

TEST(OpenStreetMap, WarningsAreBounded) {
  const ScratchFolder folder;
  std::string text = "<osm version='0.6'>";
  for (int i = 1; i <= 5000; ++i) {
    text += "<way id='" + std::to_string(i) + "'><nd ref='1'/></way>";
  }
  folder.write("map.osm", text + "</osm>");
  const auto map = read_openstreetmap(folder / "map.osm");
  ASSERT_TRUE(map);
  ASSERT_EQ(map->warnings.size(), 1001u);
  // Two per way, and one because there is no road.
  EXPECT_EQ(map->warnings.back().what, "9001 more warnings");
}

struct ClosePipe {
  void operator()(FILE* pipe) const { pclose(pipe); }
};

// Counts elements by text search, without an XML parser.
struct ElementCounts {
  size_t ways = 0, roads = 0;
};
ElementCounts count_by_text(const std::filesystem::path& path) {
  ElementCounts counted;
  const std::string command = "bzcat '" + path.string() + "'";
  const std::unique_ptr<FILE, ClosePipe> pipe(popen(command.c_str(), "r"));
  std::array<char, 65536> line{};
  bool in_way = false;
  while (pipe && std::fgets(line.data(), line.size(), pipe.get()) != nullptr) {
    const std::string text = line.data();
    if (text.find("<way ") != std::string::npos) {
      ++counted.ways;
      in_way = true;
    }
    if (text.find("</way>") != std::string::npos) in_way = false;
    if (in_way && text.find("k='highway'") != std::string::npos) ++counted.roads;
  }
  return counted;
}

TEST(OpenStreetMap, RealKarlsruheMapsMatchTheirText) {
  INFUSE_REAL_DATA_OR_SKIP(path, "street");
  for (const char* name : {"00.osm.bz2", "05.osm.bz2", "07.osm.bz2"}) {
    SCOPED_TRACE(name);
    const ElementCounts counted = count_by_text(path / name);
    if (counted.ways == 0) GTEST_SKIP() << "no bzcat";
    const auto map = read_openstreetmap(path / name);
    ASSERT_TRUE(map) << map.error().message();
    size_t roads = 0;
    for (const Way& way : map->ways) roads += !find_tag(way.tags, "highway").empty();
    size_t left_out = 0;
    for (const Error& warning : map->warnings) {
      left_out += warning.what == "has fewer than two nodes";
    }
    EXPECT_EQ(map->ways.size() + left_out, counted.ways);
    EXPECT_NEAR(static_cast<double>(roads), static_cast<double>(counted.roads),
                static_cast<double>(left_out));
    EXPECT_GT(roads, 50u);
    // All points are within a few kilometres of the centre, in Karlsruhe.
    EXPECT_NEAR(map->centre_latitude / kDegree, 49, 0.1);
    EXPECT_NEAR(map->centre_longitude / kDegree, 8.4, 0.1);
    const auto frame = gnss::make_local_frame(map->centre_latitude, map->centre_longitude);
    for (const Way& way : map->ways) {
      for (const Point& point : way.points) {
        ASSERT_LT(gnss::to_local(frame, point.latitude, point.longitude).norm(), 20'000);
      }
    }
  }
}

}  // namespace
}  // namespace infuse::osm
