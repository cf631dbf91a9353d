// Alerts as the journal gets them: a socket of this test stands in its place.

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <string>

#include "daemon/pipeline/alert_log.hpp"
#include "drivers/host/file_descriptor.hpp"
#include "tests/scratch_folder.hpp"
#include "tests/stamp_at.hpp"

namespace infuse::daemon {
namespace {

std::string journal_socket;  // of the test; empty: none

}  // namespace
}  // namespace infuse::daemon

/// Entries for systemd's socket go to that of the test.
extern "C" ssize_t sendmsg(int socket, const msghdr* message, int flags) {
  static const auto real =
      reinterpret_cast<ssize_t (*)(int, const msghdr*, int)>(dlsym(RTLD_NEXT, "sendmsg"));
  const std::string& path = infuse::daemon::journal_socket;
  const auto* to = static_cast<const sockaddr_un*>(message->msg_name);
  if (path.empty() || to == nullptr || to->sun_family != AF_UNIX ||
      std::strcmp(to->sun_path, "/run/systemd/journal/socket") != 0) {
    return real(socket, message, flags);
  }
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof(address.sun_path) - 1);
  msghdr redirected = *message;
  redirected.msg_name = &address;
  redirected.msg_namelen = sizeof(address);
  return real(socket, &redirected, flags);
}

namespace infuse::daemon {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// The daemon's standard error is the journal, which is this.
class AlertJournalTest : public testing::Test {
 protected:
  AlertJournalTest() {
    struct stat about {};
    fstat(STDERR_FILENO, &about);
    ::setenv("JOURNAL_STREAM",
             (std::to_string(about.st_dev) + ":" + std::to_string(about.st_ino)).c_str(), 1);
    journal_socket = folder_ / "journal";
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    journal_socket.copy(address.sun_path, sizeof(address.sun_path) - 1);
    EXPECT_EQ(::bind(journal_.get(), reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  }
  ~AlertJournalTest() override {
    journal_socket.clear();
    ::unsetenv("JOURNAL_STREAM");
  }

  /// The next entry; empty if there is none.
  std::string entry() const {
    std::string bytes(1 << 16, '\0');
    const ssize_t size = ::recv(journal_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    bytes.resize(size < 0 ? 0 : static_cast<size_t>(size));
    return bytes;
  }

  const ScratchFolder folder_;
  const host::FileDescriptor journal_{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
};

TEST_F(AlertJournalTest, EachAlertIsAnEntryWithPriorityAndFields) {
  AlertLog log;
  for (int k = 0; k < 13; ++k) {
    const bool severe = k % 2 == 0;
    const std::string device = "lidar_" + std::to_string(k);
    const Finding finding{"silent", severe ? Level::kError : Level::kWarn, at(1), "no data",
                          "check its power"};
    log.add({at(1), device, true, finding});
    EXPECT_THAT(
        entry(),
        AllOf(HasSubstr("MESSAGE=" + device + ".silent raised (" + (severe ? "ERROR" : "WARN") +
                        "): no data (check its power)\n"),
              HasSubstr(severe ? "PRIORITY=3\n" : "PRIORITY=4\n"),
              HasSubstr("INFUSE_ALERT=" + device + ".silent\n"),
              HasSubstr("INFUSE_DEVICE=" + device + "\n"), HasSubstr("INFUSE_STATE=raised\n"),
              HasSubstr("INFUSE_ADVICE=check its power\n"), HasSubstr("MESSAGE_ID="),
              HasSubstr("SYSLOG_IDENTIFIER=")))
        << k;
  }
  EXPECT_EQ(entry(), "");  // 13 alerts, 13 entries
  log.add({at(3), "lidar_0", false, {"silent", Level::kError, at(1), "no data", ""}});
  EXPECT_THAT(entry(), AllOf(HasSubstr("INFUSE_STATE=cleared\n"), HasSubstr("PRIORITY=4\n")));
}

}  // namespace
}  // namespace infuse::daemon
