#include "daemon/health/stream_health.hpp"
#include "tests/stamp_at.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

// A wrong baud rate looks like silence, but for the bytes.
TEST(StreamHealth, SilenceWithBytesNamesTheBaudRate) {
  StreamHealth health("/dev/ttyUSB0", HealthOptions(), at(0));
  StreamCounters counters;
  for (int second = 1; second <= 3; ++second) {
    counters.source.unread_bytes += 900;
    health.update(at(second), counters);
  }
  const StreamStatus& status = health.update(at(4), counters);
  ASSERT_EQ(status.findings.size(), 1U);
  EXPECT_STREQ(status.findings[0].id, "silent");
  EXPECT_THAT(status.findings[0].what, HasSubstr("2700 bytes without an RMC or GGA sentence"));
  EXPECT_THAT(status.findings[0].advice, HasSubstr("baud"));
}

TEST(StreamHealth, PlainSilenceNamesPowerAndConnection) {
  StreamHealth health("/dev/ttyUSB0", HealthOptions(), at(0));
  const StreamStatus& status = health.update(at(4), StreamCounters());
  ASSERT_EQ(status.findings.size(), 1U);
  EXPECT_EQ(status.findings[0].what, "no data from /dev/ttyUSB0 for 4.0 s");
  EXPECT_THAT(status.findings[0].advice, HasSubstr("power"));
}

TEST(StreamHealth, MoreThanSuchASensorSendsIsAnError) {
  StreamHealth health("/dev/ttyUSB0", HealthOptions(), at(0), 250);
  StreamCounters counters;
  Level level = Level::kOk;
  for (int second = 1; second <= 6; ++second) {
    counters.received += 24'640;
    counters.last = at(second);
    level = health.update(at(second), counters).level;
  }
  EXPECT_EQ(level, Level::kError);
}

}  // namespace
}  // namespace infuse::daemon
