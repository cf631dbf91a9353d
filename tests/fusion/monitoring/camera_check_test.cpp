#include "fusion/monitoring/camera_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace infuse::monitoring {
namespace {

constexpr int kWidth = 320, kHeight = 240;

/// Degradation of an image.
struct ImageDefects {
  double light = 1;
  bool blurred = false, patch = false, blots = false, plain_wall = false;
};

/// Scene that passes by: patterns of several scales, shifted by `at`, with a little noise.
CameraFrame make_image(int at, const ImageDefects& wrong = {}) {
  std::mt19937_64 random(static_cast<uint64_t>(at) + 1);
  CameraFrame frame;
  frame.width = kWidth;
  frame.height = kHeight;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double x = u + 37.0 * at;
      double level = 110 + 50 * std::sin(x / 17) * std::cos(v / 13.0);
      if (!wrong.blurred) level += 30 * (((static_cast<int>(x) / 7) ^ (v / 5)) % 2 == 0 ? 1 : -1);
      if (wrong.patch && u < kWidth / 2 && v > kHeight / 3) level = 90;
      if (wrong.plain_wall && v < kHeight / 2) level = 200 - v / 8.0;
      if (wrong.blots) {
        const double blot = 0.5 + 0.5 * std::sin(u / 8.0) * std::sin(v / 9.0);
        level = (1 - 0.8 * blot) * level + 0.8 * blot * 40;
      }
      level = wrong.light * level + static_cast<double>(random() % 3);
      frame.pixels.push_back(static_cast<uint8_t>(std::clamp(level, 0.0, 255.0)));
    }
  }
  return frame;
}

constexpr double kImageDistance = 4;  // m between two images

/// Check after 20 good images.
CameraCheck make_trained_check() {
  CameraCheck check({});
  for (int k = 0; k < 20; ++k) {
    EXPECT_EQ(check.process(make_image(k), kImageDistance * k), CameraFault::kNone);
  }
  return check;
}

CameraFault fault_after(CameraCheck check, int images, const auto& make) {
  CameraFault fault = CameraFault::kNone;
  for (int k = 100; k < 100 + images; ++k) fault = check.process(make(k), kImageDistance * k);
  return fault;
}

TEST(CameraCheck, NamesEachFault) {
  const CameraCheck check = make_trained_check();
  EXPECT_EQ(fault_after(check, 5, [](int k) { return make_image(k, {.light = 0.02}); }),
            CameraFault::kBlack);
  EXPECT_EQ(fault_after(check, 5, [](int) { return make_image(100); }), CameraFault::kFrozen);
  EXPECT_EQ(fault_after(check, 20, [](int k) { return make_image(k, {.blurred = true}); }),
            CameraFault::kOutOfFocus);
  EXPECT_EQ(fault_after(check, 20, [](int k) { return make_image(k, {.patch = true}); }),
            CameraFault::kDirty);
  EXPECT_EQ(fault_after(check, 40, [](int k) { return make_image(k, {.blots = true}); }),
            CameraFault::kDirty);
  EXPECT_EQ(fault_after(check, 40, [](int k) { return make_image(k); }), CameraFault::kNone);
}

TEST(CameraCheck, APlainWallThatIsPassedIsNoDirt) {
  CameraCheck check = make_trained_check();
  for (int k = 20; k < 28; ++k) {
    EXPECT_EQ(check.process(make_image(k, {.plain_wall = true}), kImageDistance * k),
              CameraFault::kNone)
        << k;
  }
  for (int k = 28; k < 60; ++k) {
    EXPECT_EQ(check.process(make_image(k), kImageDistance * k), CameraFault::kNone) << k;
  }
}

// As in fog, grey levels differ by almost nothing.
TEST(CameraCheck, WithoutContrastFocusIsNotJudged) {
  const CameraCheck check = make_trained_check();
  EXPECT_EQ(fault_after(check, 40,
                        [](int k) {
                          CameraFrame frame = make_image(k);
                          for (uint8_t& level : frame.pixels)
                            level = static_cast<uint8_t>(120 + level / 64);
                          return frame;
                        }),
            CameraFault::kNone);
}

// A side camera passes what has no fine detail.
TEST(CameraCheck, AShortBlurIsNoLensOutOfFocus) {
  const CameraCheck check = make_trained_check();
  EXPECT_EQ(
      fault_after(check, 40, [](int k) { return make_image(k, {.blurred = k >= 110 && k < 118}); }),
      CameraFault::kNone);
  CameraCheck passing = make_trained_check();
  for (int k = 20; k < 60; ++k) {
    EXPECT_EQ(passing.process(make_image(k, {.blurred = k % 10 < 8}), kImageDistance * k),
              CameraFault::kNone)
        << k;
  }
}

TEST(CameraCheck, AStandingVehicleSeesNoDirt) {
  CameraCheck check = make_trained_check();
  for (int k = 0; k < 60; ++k) {
    CameraFrame frame = make_image(20, {.plain_wall = true});
    frame.pixels[static_cast<size_t>(k)] ^= 1;
    EXPECT_EQ(check.process(frame, kImageDistance * 20), CameraFault::kNone) << k;
  }
}

TEST(CameraCheck, DirtIsClearedOnceWipedOff) {
  CameraCheck check = make_trained_check();
  CameraFault fault = CameraFault::kNone;
  for (int k = 20; k < 60; ++k)
    fault = check.process(make_image(k, {.blots = true}), kImageDistance * k);
  EXPECT_EQ(fault, CameraFault::kDirty);
  for (int k = 60; k < 70; ++k) fault = check.process(make_image(k), kImageDistance * k);
  EXPECT_EQ(fault, CameraFault::kNone);
}

TEST(CameraCheck, DuskIsNoFault) {
  const CameraCheck check = make_trained_check();
  EXPECT_EQ(fault_after(check, 40, [](int k) { return make_image(k, {.light = 0.3}); }),
            CameraFault::kNone);
}

TEST(CameraCheck, OneImageIsNotEnoughAndFaultsClear) {
  CameraCheck check = make_trained_check();
  EXPECT_EQ(check.process(make_image(30, {.light = 0.02}), kImageDistance * 30),
            CameraFault::kNone);
  for (int k = 31; k < 36; ++k) check.process(make_image(k, {.light = 0.02}), kImageDistance * k);
  EXPECT_EQ(check.fault(), CameraFault::kBlack);
  for (int k = 40; k < 45; ++k) check.process(make_image(k), kImageDistance * k);
  EXPECT_EQ(check.fault(), CameraFault::kNone);
}

TEST(CameraCheck, FaultsHaveNames) {
  EXPECT_STREQ(name_of(CameraFault::kFrozen), "frozen");
  EXPECT_STREQ(name_of(CameraFault::kOutOfFocus), "out of focus");
  EXPECT_FALSE(CameraCheckOptions{}.invalid());
  EXPECT_TRUE(CameraCheckOptions{.frozen_images = 1}.invalid());
  EXPECT_TRUE(CameraCheckOptions{.min_focus_ratio = 1}.invalid());
  EXPECT_TRUE(CameraCheckOptions{.dirty_distance = 0}.invalid());
}

}  // namespace
}  // namespace infuse::monitoring
