#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>

#include "daemon/protocol/json.hpp"
#include "drivers/camera/png_encoder.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/folders.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

constexpr int kWide = 96, kHigh = 48, kStep = 40;  // pixels
constexpr int kImages = 80;

/// A long strip of blocks of random grey values: what a camera passes.
std::vector<uint8_t> make_strip(unsigned seed) {
  std::mt19937 random(seed);
  constexpr int kBlock = 8, kColumns = kWide + kStep * (kImages + 30);
  std::vector<uint8_t> blocks((kColumns / kBlock + 1) * (kHigh / kBlock));
  for (uint8_t& value : blocks) value = static_cast<uint8_t>(40 + random() % 160);
  std::vector<uint8_t> strip;
  for (int row = 0; row < kHigh; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const int block = (row / kBlock) * (kColumns / kBlock + 1) + column / kBlock;
      strip.push_back(blocks[static_cast<size_t>(block)]);
    }
  }
  return strip;
}

class PlacesTest : public testing::Test {
 protected:
  /// Images along a strip from image `first` on; another light: darker, with noise.
  std::string write_images(const char* name, unsigned strip_seed, int first, int count,
                           bool other_light) {
    const auto strip = make_strip(strip_seed);
    const auto columns = static_cast<int>(strip.size()) / kHigh;
    std::filesystem::create_directories(folder_ / name);
    std::mt19937 random(strip_seed + 7);
    for (int k = 0; k < count; ++k) {
      CameraFrame frame;
      frame.width = kWide;
      frame.height = kHigh;
      frame.format = PixelFormat::kGrey8;
      for (int row = 0; row < kHigh; ++row) {
        for (int column = 0; column < kWide; ++column) {
          const double grey =
              strip[static_cast<size_t>(row * columns + (first + k) * kStep + column)];
          const double light = 0.35 * grey + 5 + static_cast<double>(random() % 12);
          frame.pixels.push_back(static_cast<uint8_t>(other_light ? light : grey));
        }
      }
      const auto png = camera::encode_png(frame);
      EXPECT_TRUE(png);
      char file[32];
      std::snprintf(file, sizeof(file), "%04d.png", k);
      std::ofstream(folder_ / name / file, std::ios::binary)
          .write(reinterpret_cast<const char*>(png->data()),
                 static_cast<std::streamsize>(png->size()));
    }
    return (folder_ / name).string();
  }

  static ProgramResult places(const std::string& arguments) {
    return run_shell_command(programs_folder() + "/infuse places " + arguments + " 2>&1");
  }

  const ScratchFolder folder_;
};

TEST_F(PlacesTest, FindsImagesInAnotherLight) {
  const std::string map = write_images("map", 1, 0, kImages, false);
  const std::string queries = write_images("queries", 1, 10, 60, true);
  const std::string table = (folder_ / "found.csv").string();
  const ProgramResult result = places(map + " " + queries + " --json --length 9 -o " + table);
  ASSERT_EQ(result.code, 0) << result.output;
  EXPECT_TRUE(is_result(result.output, "places"));
  const Json json = Json::parse(result.output);
  EXPECT_EQ(json["queries"], 60);
  EXPECT_EQ(json["places"], kImages);
  int found = 0, right = 0;
  for (size_t k = 0; k < 60; ++k) {
    const Json& answer = json["answers"][k];
    if (!answer["found"].get<bool>()) continue;
    ++found;
    right += std::abs(answer["index"].get<int>() - static_cast<int>(k) - 10) <= 1 ? 1 : 0;
  }
  EXPECT_EQ(json["found"], found);
  EXPECT_GE(found, 45);
  EXPECT_EQ(right, found);
  EXPECT_THAT(folder_.read("found.csv"), HasSubstr("0000.png,0010.png,"));
}

class PlacesMethods : public PlacesTest, public testing::WithParamInterface<const char*> {};

TEST_P(PlacesMethods, FindImagesInAnotherLight) {
  const std::string map = write_images("map", 1, 0, kImages, false);
  const std::string queries = write_images("queries", 1, 10, 60, true);
  const ProgramResult result = places(map + " " + queries + " --json --length 9 " + GetParam());
  ASSERT_EQ(result.code, 0) << result.output;
  const Json json = Json::parse(result.output);
  int right = 0;
  for (size_t k = 0; k < 60; ++k) {
    const Json& answer = json["answers"][k];
    const bool is_right = std::abs(answer["index"].get<int>() - static_cast<int>(k) - 10) <= 1;
    right += is_right ? 1 : 0;
    EXPECT_TRUE(is_right || !answer["found"].get<bool>()) << answer;
  }
  EXPECT_GE(right, 54) << result.output;
}
INSTANTIATE_TEST_SUITE_P(All, PlacesMethods,
                         testing::Values("--method correlation", "--method words",
                                         "--sequence mutual", "--sequence directed"));

TEST_F(PlacesTest, StatesNoChanceOfSingleImages) {
  const std::string map = write_images("map", 1, 0, kImages, false);
  const ProgramResult result = places(map + " " + map + " --sequence none --json");
  EXPECT_EQ(result.code, 0);
  EXPECT_TRUE(is_result(result.output, "places"));
  const Json answer = Json::parse(result.output)["answers"][7];
  EXPECT_EQ(answer["index"], 7);
  EXPECT_FALSE(answer.contains("chance"));
}

TEST_F(PlacesTest, DoesNotFindWhatIsNotThere) {
  const std::string map = write_images("map", 1, 0, kImages, false);
  const std::string elsewhere = write_images("elsewhere", 2, 10, 60, true);
  const ProgramResult result = places(map + " " + elsewhere + " --json");
  const Json json = Json::parse(result.output);
  EXPECT_LE(json["found"].get<int>(), 2) << result.output;
  EXPECT_THAT(places(map + " " + write_images("few", 1, 10, 12, true)).output,
              HasSubstr("too few queries"));
}

TEST_F(PlacesTest, SaysWhatIsWrong) {
  const std::string map = write_images("map", 1, 0, 3, false);
  EXPECT_EQ(places(map + " " + (folder_ / "none").string()).code, 3);
  std::filesystem::create_directories(folder_ / "empty");
  EXPECT_THAT(places(map + " " + (folder_ / "empty").string()).output,
              HasSubstr("there are no images"));
  std::filesystem::create_directories(folder_ / "damaged");
  folder_.write("damaged/0.png", "no image");
  EXPECT_THAT(places(map + " " + (folder_ / "damaged").string()).output, HasSubstr("0.png"));
  EXPECT_EQ(places(map + " " + map + " --length 0").code, 2);
  EXPECT_EQ(places(map + " " + map + " --method colours").code, 2);
  EXPECT_THAT(places(map + " " + map + " --method words --sequence mutual").output,
              HasSubstr("compares codewords of edges"));
  EXPECT_EQ(places(map + " " + map + " --method shape").code, 3);
}

}  // namespace
}  // namespace infuse::daemon
