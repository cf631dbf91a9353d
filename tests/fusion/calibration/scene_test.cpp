#include "fusion/calibration/scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

using testing::HasSubstr;

CameraFrame grey_frame() {
  CameraFrame frame;
  frame.width = 4;
  frame.height = 3;
  frame.pixels = {0, 10, 20, 30, 0, 10, 20, 30, 0, 10, 20, 200};
  return frame;
}

Sweep three_returns() {
  Sweep sweep;
  sweep.rings = 1;
  sweep.resize(3);
  for (size_t i = 0; i < 3; ++i) {
    sweep.x[i] = sweep.range[i] = 1 + 50 * static_cast<float>(i);  // 1, 51, 101 m
    sweep.y[i] = sweep.z[i] = 0;
    sweep.reflectivity[i] = 0.1F * static_cast<float>(i);
    sweep.ring[i] = 0;
    sweep.column[i] = static_cast<uint16_t>(i);
  }
  return sweep;
}

TEST(MakeScene, KeepsReturnsWithinRange) {
  const auto scene = make_scene(three_returns(), grey_frame(), {.lidar = {true, true, true}});
  ASSERT_TRUE(scene);
  ASSERT_EQ(scene->size(), 1U);
  EXPECT_FLOAT_EQ(scene->x[0], 51);
  EXPECT_FLOAT_EQ(scene->lidar[index(LidarFeature::kReflectivity)][0], 0.1F);
  EXPECT_FLOAT_EQ(scene->lidar[index(LidarFeature::kRelativeReflectivity)][0], 0.5F);
  // Its neighbour on the ring is 50 m farther, although that one is out of range.
  EXPECT_NEAR(scene->lidar[index(LidarFeature::kDiscontinuity)][0], std::sqrt(50.0), 1e-4);
}

TEST(MakeScene, PlanesAsTheyAre) {
  const auto scene = make_scene(three_returns(), grey_frame(),
                                {.image = {true, true, false, true}, .equalize = false});
  ASSERT_TRUE(scene);
  EXPECT_FLOAT_EQ(scene->image[index(ImageFeature::kGrey)].values[11], 200.0F / 255);
  EXPECT_FLOAT_EQ(scene->image[index(ImageFeature::kLocalGrey)].values[11], 200.0F / 255);
  EXPECT_FLOAT_EQ(scene->image[index(ImageFeature::kEdge)].values[11], 180.0F / 255);
}

TEST(MakeScene, RanksDoNotDependOnTheExposure) {
  CameraFrame dark = grey_frame();
  for (uint8_t& pixel : dark.pixels) pixel = static_cast<uint8_t>(pixel / 2 + 7);
  const SceneOptions ranks{.image = {true, false, true, true}};
  const auto bright_scene = make_scene(three_returns(), grey_frame(), ranks);
  const auto dark_scene = make_scene(three_returns(), dark, ranks);
  ASSERT_TRUE(bright_scene && dark_scene);
  EXPECT_EQ(bright_scene->image[index(ImageFeature::kGrey)].values,
            dark_scene->image[index(ImageFeature::kGrey)].values);
  EXPECT_EQ(bright_scene->image[index(ImageFeature::kEdge)].values.size(), 12U);
}

TEST(MakeScene, ColoursOfAColourImage) {
  CameraFrame frame = grey_frame();
  frame.format = PixelFormat::kBgr8;
  frame.pixels.assign(36, 0);
  frame.pixels[0] = 51;   // blue
  frame.pixels[1] = 102;  // green
  frame.pixels[2] = 153;  // red
  const auto scene =
      make_scene(three_returns(), frame, {.image = {true, true, true, true, true, true, true}});
  ASSERT_TRUE(scene);
  EXPECT_FLOAT_EQ(scene->image[index(ImageFeature::kBlue)].values[0], 0.2F);
  EXPECT_FLOAT_EQ(scene->image[index(ImageFeature::kGreen)].values[0], 0.4F);
  EXPECT_FLOAT_EQ(scene->image[index(ImageFeature::kRed)].values[0], 0.6F);
}

TEST(MakeScene, RefusesWhatHasNoFeatures) {
  CameraFrame mosaic = grey_frame();
  mosaic.format = PixelFormat::kBayerRggb8;
  EXPECT_THAT(make_scene(three_returns(), mosaic, {}).error().message(), HasSubstr("Bayer"));
  CameraFrame torn = grey_frame();
  torn.pixels.pop_back();
  EXPECT_FALSE(make_scene(three_returns(), torn, {}));
  EXPECT_FALSE(make_scene(three_returns(), CameraFrame{}, {}));
  EXPECT_THAT(make_scene(Sweep{}, grey_frame(), {}).error().message(), HasSubstr("range"));
}

TEST(MakeScene, RefusesASweepWithoutRingsWhereAFeatureNeedsThem) {
  Sweep sweep = three_returns();
  sweep.rings = 0;
  EXPECT_THAT(make_scene(sweep, grey_frame(), {}).error().message(), HasSubstr("field 'ring'"));
  EXPECT_TRUE(make_scene(sweep, grey_frame(), {.lidar = {true}}));
}

TEST(SceneOptions, SaysWhatIsWrong) {
  EXPECT_FALSE(SceneOptions{}.invalid());
  EXPECT_TRUE((SceneOptions{.min_range = 10, .max_range = 5}.invalid()));
  EXPECT_THAT(*(SceneOptions{.discontinuity = {.gamma = -1}}.invalid()), HasSubstr("gamma"));
}

}  // namespace
}  // namespace infuse::calibration
