#include "daemon/service/ptp_clocks.hpp"

#include <fcntl.h>
#include <linux/ptp_clock.h>
#include <sys/ioctl.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "drivers/host/file_descriptor.hpp"

namespace infuse::daemon {
namespace {

constexpr unsigned kOffsetSamples = 5;
constexpr int kMaxPtpClocks = 16;
/// TAI − UTC since 2017, s (IERS, Bulletin C): ptp4l's clocks count TAI, a host's UTC.
constexpr double kTaiMinusUtc = 37;

int64_t nanoseconds(const ptp_clock_time& time) {
  return time.sec * 1'000'000'000 + static_cast<int64_t>(time.nsec);
}

/// The best of samples (host before, device, host after).
class BestOffset {
 public:
  void add(const ptp_clock_time& before, const ptp_clock_time& device,
           const ptp_clock_time& after) {
    const int64_t delay = nanoseconds(after) - nanoseconds(before);
    if (delay < 0 || delay >= delay_) return;
    delay_ = delay;
    offset_ = nanoseconds(device) - nanoseconds(before) - delay / 2;
  }
  std::optional<double> seconds() const {
    if (!offset_) return std::nullopt;
    return static_cast<double>(*offset_) * 1e-9;
  }

 private:
  int64_t delay_ = std::numeric_limits<int64_t>::max();
  std::optional<int64_t> offset_;
};

}  // namespace

std::optional<double> ptp_offset(const std::filesystem::path& device) {
  const host::FileDescriptor file(
      ::open(device.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (!file) return std::nullopt;
  BestOffset best;
  ptp_sys_offset_extended extended{};
  extended.n_samples = kOffsetSamples;
  if (::ioctl(file.get(), PTP_SYS_OFFSET_EXTENDED, &extended) == 0) {
    for (unsigned k = 0; k < kOffsetSamples; ++k) {
      best.add(extended.ts[k][0], extended.ts[k][1], extended.ts[k][2]);
    }
    return best.seconds();
  }
  ptp_sys_offset plain{};  // host, device, host, device … host
  plain.n_samples = kOffsetSamples;
  if (::ioctl(file.get(), PTP_SYS_OFFSET, &plain) != 0) return std::nullopt;
  for (unsigned k = 0; k < kOffsetSamples; ++k) {
    best.add(plain.ts[2 * k], plain.ts[2 * k + 1], plain.ts[2 * k + 2]);
  }
  return best.seconds();
}

PtpClocks::PtpClocks(std::filesystem::path folder, Ask ask)
    : folder_(std::move(folder)), ask_(std::move(ask)) {}

std::vector<PtpClock> PtpClocks::ask() const {
  std::vector<PtpClock> clocks;
  for (int k = 0; k < kMaxPtpClocks; ++k) {
    const std::string name = "ptp" + std::to_string(k);
    const std::optional<double> offset = ask_(folder_ / name);
    if (!offset) continue;
    const bool counts_tai = std::abs(*offset - kTaiMinusUtc) < std::abs(*offset);
    clocks.push_back({name, *offset - (counts_tai ? kTaiMinusUtc : 0)});
  }
  return clocks;
}

}  // namespace infuse::daemon
