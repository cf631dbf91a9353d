// The live daemon on disks that fail: it runs on, says so, and destroys nothing.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>

#include "tests/daemon/live_daemon.hpp"
#include "tests/faults/disk_fault.hpp"

namespace infuse::daemon {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;

/// Nobody listens there.
constexpr const char* kBroker =
    "[mqtt]\nhost = \"127.0.0.1\"\nport = 1\nvehicle = \"car\"\nhealth_interval_s = 0.5\n";

TEST(DiskFault, ADiskThatFailsWhileTheDaemonRunsIsSaid) {
  const ScratchFolder folder;
  LiveDaemon daemon(folder, kBroker);
  EXPECT_THAT(daemon.wait_for("mqtt on disk"), ContainsRegex("OK +mqtt on disk: .* GB free"));
  {
    const DiskFault fault(folder / "state", EIO);
    EXPECT_THAT(daemon.wait_for("WARN  mqtt on disk"), HasSubstr("WARN  mqtt on disk"));
  }
  EXPECT_THAT(daemon.wait_for("OK    mqtt on disk"), HasSubstr("OK    mqtt on disk"));
  EXPECT_EQ(daemon.stop(), 0);
}

TEST(DiskFault, OnADiskThatIsFullOrReadOnlyTheDaemonStartsAndDestroysNothing) {
  const ScratchFolder folder;
  LiveDaemon(folder, kBroker).wait_for("mqtt on disk");  // killed: reports wait in the file
  const std::string before = folder.read("state/mqtt.db") + folder.read("state/mqtt.db-wal");
  ASSERT_FALSE(before.empty());
  for (const int error : {ENOSPC, EROFS}) {
    const DiskFault fault(folder / "state", error);
    LiveDaemon daemon(folder, kBroker);
    EXPECT_THAT(daemon.wait_for("on disk"), HasSubstr("mqtt on disk"));
    EXPECT_EQ(daemon.stop(), 0);
    for (const auto& file : std::filesystem::directory_iterator(folder / "state")) {
      EXPECT_EQ(file.path().string().find("damaged"), std::string::npos) << file.path();
    }
  }
  EXPECT_NE(folder.read("state/mqtt.db").size(), 0U);
}

}  // namespace
}  // namespace infuse::daemon
