#include "daemon/service/ptp_clocks.hpp"

#include <gtest/gtest.h>
#include <linux/ptp_clock.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdint>

#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

/// Whether a file is a clock to the kernel, and of which kernel.
enum class Kernel { kReal, kExtended, kPlain };
Kernel pretended = Kernel::kReal;

constexpr unsigned kBestSample = 2;

ptp_clock_time time_of(int64_t ns) {
  return {
      .sec = ns / 1'000'000'000, .nsec = static_cast<uint32_t>(ns % 1'000'000'000), .reserved = 0};
}

/// Host before, device, host after, which is the next before; but for the best sample the device is
/// read late.
void sample(unsigned k, ptp_clock_time& before, ptp_clock_time& device, ptp_clock_time& after) {
  constexpr int64_t kDelay = 90'000, kLeast = 2'000;  // ns
  const int64_t earlier = k * kDelay - (k > kBestSample ? kDelay - kLeast : 0);
  const int64_t begin = 100'000'000'000 + earlier, delay = k == kBestSample ? kLeast : kDelay;
  before = time_of(begin);
  device = time_of(begin + (k == kBestSample ? delay / 2 : delay) + 37'250'000'000);
  after = time_of(begin + delay);
}

}  // namespace
}  // namespace infuse::daemon

extern "C" int ioctl(int file, unsigned long request, ...) noexcept {
  using namespace infuse::daemon;
  va_list arguments;
  va_start(arguments, request);
  void* const argument = va_arg(arguments, void*);
  va_end(arguments);
  if (pretended == Kernel::kExtended && request == PTP_SYS_OFFSET_EXTENDED) {
    auto& asked = *static_cast<ptp_sys_offset_extended*>(argument);
    for (unsigned k = 0; k < asked.n_samples; ++k) {
      sample(k, asked.ts[k][0], asked.ts[k][1], asked.ts[k][2]);
    }
    return 0;
  }
  if (pretended == Kernel::kPlain && request == PTP_SYS_OFFSET) {
    auto& asked = *static_cast<ptp_sys_offset*>(argument);
    for (unsigned k = 0; k < asked.n_samples; ++k) {
      sample(k, asked.ts[2 * k], asked.ts[2 * k + 1], asked.ts[2 * k + 2]);
    }
    return 0;
  }
  return static_cast<int>(syscall(SYS_ioctl, file, request, argument));
}

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

// The sample of the least delay is exact, the others are not; 37.25 s are between the clocks.
TEST(PtpClocks, TheSampleOfLeastDelayCounts) {
  const ScratchFolder folder;
  folder.write("ptp0", "");
  for (const Kernel kernel : {Kernel::kExtended, Kernel::kPlain}) {
    pretended = kernel;
    const auto offset = ptp_offset(folder / "ptp0");
    pretended = Kernel::kReal;
    ASSERT_TRUE(offset);
    EXPECT_NEAR(*offset, 37.25, 1e-9);
  }
  EXPECT_FALSE(ptp_offset(folder / "ptp0"));
}

}  // namespace
}  // namespace infuse::daemon
