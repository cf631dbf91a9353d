#include "drivers/import/folder_import.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/recording/drive_source.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/drivers/import/png_header.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {
namespace {

using ::testing::HasSubstr;
using namespace std::string_literals;

constexpr int64_t kCaptureNs = 1'700'000'600'000'000'000;  // when a fixture's capture begins

// The header of a PNG of 64 × 48 pixels; the import reads nothing else.
std::string describe_folder(const std::string& stamps, const std::string& more = "") {
  return "[[lidar]]\nname = \"top\"\npackets = \"top.pcap\"\n"
         "T_vehicle_lidar = [1, 0, 0, 0.5,  0, 1, 0, 0,  0, 0, 1, 1.8,  0, 0, 0, 1]\n" +
         more +
         "[[camera]]\nname = \"left\"\nimages = \"photos\"\n"
         "width = 64\nheight = 48\nfx = 50\nfy = 50\ncx = 32\ncy = 24\nlidar = \"top\"\n"
         "T_camera_lidar = [0, -1, 0, 0,  0, 0, -1, 0,  1, 0, 0, -0.27,  0, 0, 0, 1]\n"
         "stamps = " +
         stamps + "\n";
}

/// A folder with a capture of 0.3 s and images of these names.
void write_folder(const ScratchFolder& folder, const std::vector<std::string>& images) {
  std::filesystem::create_directories(folder / "in");
  ASSERT_TRUE(fixtures::make_capture(folder / "in/top.pcap", {.duration = Duration(300'000'000)}));
  for (const std::string& name : images) folder.write("in/photos/" + name, make_png());
}

Result<FolderImportSummary> import_described(const ScratchFolder& folder,
                                             const std::string& description) {
  folder.write("in/folder.toml", description);
  std::filesystem::remove_all(folder / "drive");
  return import_folder(folder / "in/folder.toml", folder / "drive");
}

/// Stamps of the drive's images after the capture's begin, ms.
std::vector<double> image_times(const ScratchFolder& folder) {
  const auto drive = recording::Drive::open(folder / "drive");
  EXPECT_TRUE(drive) << drive.error().message();
  if (!drive) return {};
  auto source = recording::DriveSource::open(*drive);
  EXPECT_TRUE(source) << source.error().message();
  std::vector<double> times;
  for (recording::DriveEvent event; source && source->next(event);) {
    if (std::holds_alternative<recording::ImageEvent>(event.content))
      times.push_back(static_cast<double>(event.stamp.ns() - kCaptureNs) * 1e-6);
  }
  return times;
}

TEST(FolderImport, StampsComeFromATableInTheOrderOfTheNumbersInNames) {
  const ScratchFolder folder;
  write_folder(folder, {"p10.JPG", "p2.jpeg", "p1.png"});
  folder.write("in/stamps.csv",
               "# of the camera\nframe,time\n0,1700000600050000\n1,1700000600150000\n"
               "2,1700000600250000.5\n");
  const auto imported = import_described(
      folder, describe_folder(R"({ file = "stamps.csv", column = "time", unit = "us" })"));
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->images, 3u);
  EXPECT_TRUE(imported->notes.empty());
  EXPECT_EQ(image_times(folder), (std::vector<double>{50, 150, 250.0005}));
  EXPECT_TRUE(std::filesystem::equivalent(folder / "drive/images_left/000002.jpg",
                                          folder / "in/photos/p10.JPG"));
  EXPECT_TRUE(std::filesystem::equivalent(folder / "drive/images_left/000000.png",
                                          folder / "in/photos/p1.png"));
  const auto drive = recording::Drive::open(folder / "drive");
  EXPECT_EQ(drive->description.rig.lidars.at(0).model, "HDL-32E");
}

TEST(FolderImport, TableMayNameTheFiles) {
  const ScratchFolder folder;
  write_folder(folder, {"a.png", "b.png", "c.png"});
  // As TUM's rgb.txt, with dates; b before a; none for c, none named d.
  folder.write("in/list.txt",
               "2023-11-14 22:23:20.200 rgb/a.png\n2023-11-14 22:23:20.100 rgb/b.png\n"
               "2023-11-14 22:23:20.300 rgb/d.png\n");
  const auto imported = import_described(
      folder, describe_folder(R"({ file = "list.txt", files_column = 2, offset_s = -0.01 })"));
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(image_times(folder), (std::vector<double>{90, 190}));
  EXPECT_TRUE(std::filesystem::equivalent(folder / "drive/images_left/000000.png",
                                          folder / "in/photos/b.png"));
  ASSERT_EQ(imported->notes.size(), 2u);
  EXPECT_THAT(imported->notes[0].what, HasSubstr("1 files are not taken"));
  EXPECT_THAT(imported->notes[1].what, HasSubstr("1 rows are of files"));
}

TEST(FolderImport, StampsComeFromNamesOrFromARate) {
  const ScratchFolder folder;
  write_folder(folder, {"cam0_1700000600100.png", "cam0_1700000600200.png"});
  const auto named = import_described(folder, describe_folder(R"({ names = true, unit = "ms" })"));
  ASSERT_TRUE(named) << named.error().message();
  EXPECT_EQ(image_times(folder), (std::vector<double>{100, 200}));
  EXPECT_TRUE(named->notes.empty());
  const auto rated = import_described(
      folder, describe_folder(R"({ rate_hz = 10, start = "2023-11-14T22:23:20.05Z" })"));
  ASSERT_TRUE(rated) << rated.error().message();
  EXPECT_EQ(image_times(folder), (std::vector<double>{50, 150}));
  ASSERT_EQ(rated->notes.size(), 1u);
  EXPECT_THAT(rated->notes[0].what, HasSubstr("not measured"));
  ASSERT_TRUE(import_described(folder, describe_folder("{ rate_hz = 5 }")));
  const auto times = image_times(folder);
  ASSERT_EQ(times.size(), 2u);
  EXPECT_GE(times[0], 0);
  EXPECT_LT(times[0], 5);  // the first packet
  EXPECT_NEAR(times[1] - times[0], 200, 1e-6);
}

TEST(FolderImport, OtherFilesOfADriveAreTaken) {
  const ScratchFolder folder;
  write_folder(folder, {"1700000600.1.png"});
  folder.write("in/bus/speed.csv", "stamp_ns,speed\n1700000600100000000,5\n");
  const auto imported = import_described(
      folder, describe_folder("{ names = true }") + "[speed]\nfile = \"bus/speed.csv\"\n");
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(folder.read("drive/bus/speed.csv"), folder.read("in/bus/speed.csv"));
  const auto missing = import_described(
      folder, describe_folder("{ names = true }") + "[speed]\nfile = \"bus/none.csv\"\n");
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message(), HasSubstr("bus/none.csv"));
  // A link in its place would let the new description overwrite it.
  folder.write("in/drive.toml", "mine");
  EXPECT_FALSE(import_described(
      folder, describe_folder("{ names = true }") + "[speed]\nfile = \"bus/../drive.toml\"\n"));
  EXPECT_EQ(folder.read("in/drive.toml"), "mine");
}

TEST(FolderImport, SweepsMayHaveStampsInstead) {
  const ScratchFolder folder;
  const std::string pcd =
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA "
      "ascii\n5 0 0\n";
  folder.write("in/clouds/s_1700000600.pcd", pcd);
  folder.write("in/clouds/s_1700000601.pcd", pcd);
  folder.write("in/photos/1700000600.5.png", make_png());
  std::string description = describe_folder("{ names = true }");
  const std::string packets = "packets = \"top.pcap\"\n";
  description.replace(description.find(packets), packets.size(),
                      "sweeps = \"clouds\"\nstamps = { names = true }\n");
  const auto imported = import_described(folder, description);
  ASSERT_TRUE(imported) << imported.error().message();
  EXPECT_EQ(imported->sweeps, 2u);
  EXPECT_EQ(image_times(folder), (std::vector<double>{500}));
}

struct WrongFolder {
  std::string stamps, more;  ///< of the description
  std::string message;       ///< part of the error
};

TEST(FolderImport, WrongDescriptionsAreRefusedWithTheirPlace) {
  const ScratchFolder folder;
  write_folder(folder, {"a_1700000600100.png", "b_1700000600200.png"});
  folder.write("in/one.csv", "time\n1700000600.1\n");
  folder.write("in/text.csv", "time,x\n1700000600.1,1\nlater,2\n");
  folder.write("in/empty.csv", "time\n");
  const std::vector<WrongFolder> all = {
      {"{ file = \"one.csv\" }", "", "one.csv: has 1 stamps for 2 files"},
      {"{ file = \"text.csv\" }", "", "text.csv:3: has no stamp in s ('later,2')"},
      {"{ file = \"text.csv\", column = \"t\" }", "",
       "text.csv:1: has no column 't' (columns: time, x)"},
      {"{ file = \"text.csv\", files_column = 9 }", "", "text.csv:1: has no column '9'"},
      {"{ file = \"empty.csv\" }", "", "empty.csv: has no stamps"},
      {"{ file = \"none.csv\" }", "", "none.csv"},
      {"{ names = true, unit = \"min\" }", "", "folder.toml:16: stamps: unit must be"},
      {"{ names = true, rate_hz = 3 }", "", "folder.toml:16: stamps: give one of"},
      {"{ rate_hz = 0 }", "", "folder.toml:16: stamps: rate_hz must be"},
      {"{ rate_hz = 1, start = \"noon\" }", "", "folder.toml:16: start must be a date"},
      {"{ names = true, colum = 1 }", "", "folder.toml:16: unknown key 'colum'"},
      {"{ names = 1 }", "", "folder.toml:16: names must be true or false"},
      {"{}", "", "stamps: give one of"},
      {"3", "", "folder.toml:16: stamps must be a table"},
      {"{ names = true, unit = \"us\" }", "", "folder.toml:7: no image is within the time"},
      {"{ names = true, unit = \"ms\" }", "port = 2369\n",
       "folder.toml:5: 'top.pcap' has no data packets"},
      {"{ names = true, unit = \"ms\" }", "stamps = { names = true }\n", "leave out stamps"},
      {"{ names = true, unit = \"ms\" }", "modle = \"x\"\n", "folder.toml:5: unknown key 'modle'"},
      {"{ names = true, unit = \"ms\" }\nwidth = 1", "", "folder.toml:17"},
  };
  for (const WrongFolder& wrong : all) {
    const auto refused = import_described(folder, describe_folder(wrong.stamps, wrong.more));
    ASSERT_FALSE(refused) << wrong.stamps;
    EXPECT_THAT(refused.error().message(), HasSubstr(wrong.message));
    EXPECT_FALSE(std::filesystem::exists(folder / "drive"));
  }
  std::string other = describe_folder("{ names = true, unit = \"ms\" }");
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = other;
    return text.replace(text.find(from), from.size(), to);
  };
  for (const auto& [from, to, message] : std::vector<std::array<std::string, 3>>{
           {"width = 64", "width = 65", "folder.toml:8: the images are 65x48, but"},
           {"photos", "none", "folder.toml:7: "},
           {"\"top.pcap", "\"none.pcap", "folder.toml:3: there is no file 'none.pcap'"},
           {"\"top.pcap", "\"../top.pcap", "folder.toml:1: "},
           {"stamps =", "stamp =", "unknown key 'stamp'"},
           {"stamps = { names = true, unit = \"ms\" }", "",
            "folder.toml:7: a camera must have stamps"}}) {
    const auto refused = import_described(folder, replaced(from, to));
    ASSERT_FALSE(refused) << to;
    EXPECT_THAT(refused.error().message(), HasSubstr(message));
  }
  EXPECT_FALSE(import_folder(folder / "none.toml", folder / "drive"));
}

TEST(FolderStamps, UnitsAreExact) {
  EXPECT_EQ(parse_stamp_in("1700000000.123456789", "s")->ns(), 1'700'000'000'123'456'789);
  EXPECT_EQ(parse_stamp_in("1700000000123.456789", "ms")->ns(), 1'700'000'000'123'456'789);
  EXPECT_EQ(parse_stamp_in("1700000000123456.789", "us")->ns(), 1'700'000'000'123'456'789);
  EXPECT_EQ(parse_stamp_in("1700000000123456789", "ns")->ns(), 1'700'000'000'123'456'789);
  EXPECT_EQ(parse_stamp_in("7", "ns")->ns(), 7);
  EXPECT_EQ(parse_stamp_in("1970-01-02T00:00:01Z", "s")->ns(), 86'401'000'000'000);
  for (const char* wrong : {"", ".", "-1", "1e9", "17000000000000000000", "1.2.3", "x"})
    EXPECT_FALSE(parse_stamp_in(wrong, "ms")) << wrong;
  EXPECT_FALSE(parse_stamp_in("-1", "s"));
  EXPECT_EQ(parse_stamp_in_name("left_0012_1700000000.25", "s")->ns(), 1'700'000'000'250'000'000);
  EXPECT_EQ(parse_stamp_in_name("t1700000000250-raw", "ms")->ns(), 1'700'000'000'250'000'000);
  EXPECT_FALSE(parse_stamp_in_name("left", "s"));
}

}  // namespace
}  // namespace infuse::importers
