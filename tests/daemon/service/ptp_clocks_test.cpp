#include "daemon/service/ptp_clocks.hpp"

#include <gtest/gtest.h>

#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

TEST(PtpClocks, CountTaiOrUtcAndComeAndGo) {
  std::optional<double> first = 37.000'25, second;
  const PtpClocks clocks("/dev", [&](const std::filesystem::path& device) {
    return device == "/dev/ptp0" ? first : device == "/dev/ptp3" ? second : std::nullopt;
  });
  auto found = clocks.ask();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].device, "ptp0");
  EXPECT_NEAR(found[0].offset_s, 250e-6, 1e-12);
  EXPECT_TRUE(found[0].agrees());
  second = -1'700'000'000;  // from its own start, as a clock that nothing keeps
  first = -0.002;
  found = clocks.ask();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].offset_s, -0.002);
  EXPECT_FALSE(found[0].agrees());
  EXPECT_EQ(found[1].device, "ptp3");
  EXPECT_FALSE(found[1].agrees());
  first.reset();
  EXPECT_EQ(clocks.ask().size(), 1U);
}

TEST(PtpClocks, WhatIsNoClockDoesNotAnswer) {
  const ScratchFolder folder;
  folder.write("ptp0", "no device");
  EXPECT_FALSE(ptp_offset(folder / "ptp0"));
  EXPECT_FALSE(ptp_offset(folder / "missing"));
  EXPECT_FALSE(ptp_offset("/dev/null"));
  EXPECT_TRUE(PtpClocks(folder / "").ask().empty());
}

// Where the kernel has one that this user may read, it keeps time.
TEST(PtpClocks, ARealClockAnswers) {
  const auto first = ptp_offset("/dev/ptp0");
  if (!first) GTEST_SKIP() << "no /dev/ptp0 that may be read";
  const auto second = ptp_offset("/dev/ptp0");
  ASSERT_TRUE(second);
  EXPECT_NEAR(*first, *second, 0.1);
}

}  // namespace
}  // namespace infuse::daemon
