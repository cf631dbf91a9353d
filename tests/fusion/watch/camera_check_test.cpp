#include "fusion/watch/camera_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace infuse::watch {
namespace {

constexpr int kWidth = 320, kHeight = 240;

/// A scene that passes by: patterns of several scales, shifted by `at`, with a little noise.
CameraFrame picture(int at, double light = 1, bool blurred = false, bool dirt = false) {
  std::mt19937_64 random(static_cast<uint64_t>(at) + 1);
  CameraFrame frame;
  frame.width = kWidth;
  frame.height = kHeight;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double x = u + 3.0 * at;
      double level = 110 + 50 * std::sin(x / 17) * std::cos(v / 13.0);
      if (!blurred) level += 30 * (((static_cast<int>(x) / 5) ^ (v / 5)) % 2 == 0 ? 1 : -1);
      if (dirt && u < kWidth / 2 && v > kHeight / 3) level = 90;
      level = light * level + static_cast<double>(random() % 3);
      frame.pixels.push_back(static_cast<uint8_t>(std::clamp(level, 0.0, 255.0)));
    }
  }
  return frame;
}

/// A camera that has seen 20 good pictures.
CameraCheck used_to() {
  CameraCheck check({});
  for (int k = 0; k < 20; ++k) {
    EXPECT_EQ(check.take(picture(k), true), CameraFault::kNone);
  }
  return check;
}

CameraFault after(CameraCheck check, int pictures, const auto& make) {
  CameraFault fault = CameraFault::kNone;
  for (int k = 0; k < pictures; ++k) fault = check.take(make(100 + k), true);
  return fault;
}

TEST(CameraCheck, NamesEachFault) {
  const CameraCheck check = used_to();
  EXPECT_EQ(after(check, 5, [](int k) { return picture(k, 0.02); }), CameraFault::kBlack);
  EXPECT_EQ(after(check, 5, [](int) { return picture(100); }), CameraFault::kFrozen);
  EXPECT_EQ(after(check, 5, [](int k) { return picture(k, 1, true); }), CameraFault::kOutOfFocus);
  EXPECT_EQ(after(check, 5, [](int k) { return picture(k, 1, false, true); }), CameraFault::kDirty);
  EXPECT_EQ(after(check, 5, [](int k) { return picture(k); }), CameraFault::kNone);
}

TEST(CameraCheck, DuskIsNoFault) {
  const CameraCheck check = used_to();
  EXPECT_EQ(after(check, 10, [](int k) { return picture(k, 0.3); }), CameraFault::kNone);
}

TEST(CameraCheck, OnePictureIsNotEnoughAndFaultsPass) {
  CameraCheck check = used_to();
  EXPECT_EQ(check.take(picture(30, 0.02), true), CameraFault::kNone);
  for (int k = 0; k < 5; ++k) check.take(picture(31 + k, 0.02), true);
  EXPECT_EQ(check.fault(), CameraFault::kBlack);
  for (int k = 0; k < 5; ++k) check.take(picture(40 + k), true);
  EXPECT_EQ(check.fault(), CameraFault::kNone);
}

TEST(CameraCheck, FaultsHaveNames) {
  EXPECT_STREQ(to_string(CameraFault::kFrozen), "frozen");
  EXPECT_STREQ(to_string(CameraFault::kOutOfFocus), "out of focus");
  EXPECT_FALSE(CameraCheckOptions{}.invalid());
  EXPECT_TRUE(CameraCheckOptions{.frozen_pictures = 1}.invalid());
  EXPECT_TRUE(CameraCheckOptions{.lost_focus = 1}.invalid());
}

}  // namespace
}  // namespace infuse::watch
