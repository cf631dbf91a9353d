#include "drivers/recording/turn.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace infuse::recording {
namespace {

Sweep sweep_of(std::initializer_list<double> azimuths_deg) {
  Sweep sweep;
  sweep.stamp = Stamp::from_ns(1'000'000'000);
  sweep.span = Duration(100'000'000);
  sweep.has_times = false;
  sweep.resize(azimuths_deg.size());
  size_t i = 0;
  for (const double azimuth : azimuths_deg) {
    sweep.x[i] = static_cast<float>(10 * std::cos(azimuth * M_PI / 180));
    sweep.y[i] = static_cast<float>(10 * std::sin(azimuth * M_PI / 180));
    ++i;
  }
  return sweep;
}

std::vector<double> times_ms(const Sweep& sweep) {
  std::vector<double> times;
  for (const int32_t offset : sweep.time_offset_ns) times.push_back(offset * 1e-6);
  return times;
}

void expect_near(const std::vector<double>& times, const std::vector<double>& expected) {
  ASSERT_EQ(times.size(), expected.size());
  for (size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(times[i], expected[i], 1.1e-3) << i;
}

// KITTI: t = start + (end − start) · (½ − yaw / 2π).
TEST(Turn, ClockwiseFromTheRear) {
  Sweep sweep = sweep_of({179.64, 90, 0, -90, -179.64});
  assign_turn_times({}, sweep);
  EXPECT_TRUE(sweep.has_times);
  EXPECT_FALSE(sweep.deskewed);
  expect_near(times_ms(sweep), {0.1, 25, 50, 75, 99.9});
}

TEST(Turn, CounterClockwiseWithAnotherCut) {
  Sweep sweep = sweep_of({91, 180, -90, 0, 89});
  assign_turn_times({.clockwise = false, .cut_deg = 90}, sweep);
  expect_near(times_ms(sweep), {100. / 360, 25, 50, 75, 100 - 100. / 360});
}

TEST(Turn, EachRingFromItsOwnCut) {
  Sweep sweep = sweep_of({180, 180, 0, 0});
  sweep.rings = 2;
  sweep.ring = {0, 1, 0, 1};
  const Turn turn{.ring_cuts_deg = {183.6, 176.4}};
  assign_turn_times(turn, sweep);
  expect_near(times_ms(sweep), {1, 99, 51, 49});
  sweep.rings = 3;  // another lidar's list
  assign_turn_times(turn, sweep);
  expect_near(times_ms(sweep), {0, 0, 50, 50});
}

TEST(Turn, DeskewedReturnsHaveTheTimeOfTheMiddle) {
  Sweep sweep = sweep_of({10, 200});
  assign_middle_time(sweep);
  EXPECT_TRUE(sweep.has_times);
  EXPECT_TRUE(sweep.deskewed);
  expect_near(times_ms(sweep), {50, 50});
}

}  // namespace
}  // namespace infuse::recording
