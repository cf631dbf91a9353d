#include "daemon/tools/calibrate/time_sigma.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace infuse::daemon {
namespace {

TEST(TimeSigma, IsThatOfTheWorstCameraByItsKind) {
  std::array<CameraMount, 2> cameras;
  cameras[0].name = "triggered";
  cameras[1].name = "webcam";
  EXPECT_EQ(default_time_sigma(cameras).sigma, Duration(1'000'000));
  EXPECT_EQ(default_time_sigma(cameras).note, "");
  cameras[1].readout = Duration(30'000'000);
  const TimeSigma unknown = default_time_sigma(cameras);
  EXPECT_NEAR(to_seconds(unknown.sigma), 1 / 30.0 / std::sqrt(12), 1e-4);
  EXPECT_NE(unknown.note.find("'webcam'"), std::string::npos);
  // Measured: what remains is stated, and counts by itself.
  cameras[1].stamp_delay_sigma = Duration(2'000'000);
  EXPECT_EQ(default_time_sigma(cameras).sigma, Duration(1'000'000));
}

}  // namespace
}  // namespace infuse::daemon
