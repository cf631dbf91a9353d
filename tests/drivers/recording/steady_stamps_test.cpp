#include "drivers/recording/steady_stamps.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace infuse::recording {
namespace {

/// Milliseconds out for milliseconds in.
std::vector<int64_t> steady(SteadyStamps& stamps, const std::vector<int64_t>& raw_ms) {
  std::vector<int64_t> out;
  for (const int64_t ms : raw_ms) {
    out.push_back(stamps.steady(Stamp::from_ns(ms * 1'000'000)).ns() / 1'000'000);
  }
  return out;
}

using Times = std::vector<int64_t>;

TEST(SteadyStamps, RunOnWhereTheClockIsSetBack) {
  SteadyStamps stamps;
  EXPECT_EQ(steady(stamps, {10'000, 10'001, 10'002, 8'002, 8'003, 8'004, 7'004}),
            (Times{10'000, 10'001, 10'002, 10'002, 10'003, 10'004, 10'004}));
  EXPECT_EQ(stamps.steps(), 2U);
  EXPECT_EQ(stamps.largest(), from_seconds(2));
}

TEST(SteadyStamps, SmallDisorderAndGapsStayAsTheyAre) {
  SteadyStamps stamps;
  const Times raw{10'000, 10'100, 10'050, 10'110, 99'000, 99'001, 98'950};
  EXPECT_EQ(steady(stamps, raw), raw);
  EXPECT_EQ(stamps.steps(), 0U);
}

TEST(SteadyStamps, OneOddStampIsNoStep) {
  for (const int64_t odd : {9'000'000, 3'000, 0}) {
    SteadyStamps stamps;
    const Times out = steady(stamps, {10'000, 10'001, 10'002, odd, 10'003, 10'004});
    EXPECT_EQ(Times(out.begin() + 4, out.end()), (Times{10'003, 10'004})) << odd;
    EXPECT_EQ(stamps.steps(), 0U) << odd;
  }
}

}  // namespace
}  // namespace infuse::recording
