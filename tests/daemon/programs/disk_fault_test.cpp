// The live daemon on disks that fail: it runs on, says so, and destroys nothing.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <vector>

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
  LiveDaemon daemon(folder, kBroker, "/dev/full");
  EXPECT_THAT(daemon.wait_for("mqtt on disk"), ContainsRegex("OK +mqtt on disk: .* GB free"));
  EXPECT_THAT(daemon.wait_for("WARN  mcap on disk"), HasSubstr("WARN  mcap on disk: /dev/full"));
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

// The files of state, history and calibrations: run_tracker_test, history_writer_test and
// calibration_ledger_test.
TEST(DiskFault, RecordingsAndReportsForTheBrokerGoOnAfterwards) {
  struct Disk {
    explicit Disk(int its_error) : error(its_error) { daemon.wait_for("mqtt on disk"); }
    ProgramResult record(const char* name) const {
      return run_shell_command(programs_folder() + "/infuse record --no-wait " + name +
                               " --socket " + (folder / "s").string() + " 2>&1");
    }
    int error;
    ScratchFolder folder;
    LiveDaemon daemon{folder, kBroker};
  };
  Disk disks[] = {Disk(ENOSPC), Disk(EIO), Disk(EROFS)};
  {
    std::vector<std::unique_ptr<DiskFault>> faults;
    for (const Disk& disk : disks)
      faults.push_back(std::make_unique<DiskFault>(disk.folder / "state", disk.error));
    for (const Disk& disk : disks) {
      const auto refused = disk.record("refused");
      EXPECT_NE(refused.code, 0);
      EXPECT_THAT(refused.output, HasSubstr(std::strerror(disk.error)));
      EXPECT_THAT(disk.daemon.wait_for("WARN  mqtt on"), HasSubstr("WARN  mqtt on disk"));
    }
  }
  for (Disk& disk : disks) {
    EXPECT_THAT(disk.daemon.wait_for("OK    mqtt on"), HasSubstr("OK    mqtt on disk"));
    const auto recorded = disk.record("recorded");
    EXPECT_EQ(recorded.code, 0) << recorded.output;
    EXPECT_TRUE(std::filesystem::exists(disk.folder / "state/drives/recorded/drive.toml"));
    EXPECT_EQ(disk.daemon.stop(), 0);
  }
}

}  // namespace
}  // namespace infuse::daemon
