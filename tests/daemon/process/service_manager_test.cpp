#include "daemon/process/service_manager.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

namespace infuse::daemon {
namespace {

/// The service manager's end of $NOTIFY_SOCKET.
class FakeServiceManager {
 public:
  FakeServiceManager() {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string name = "infuse-notify-" + std::to_string(getpid());
    name.copy(address.sun_path + 1, sizeof(address.sun_path) - 2);  // abstract socket name
    const auto size = static_cast<socklen_t>(sizeof(sa_family_t) + 1 + name.size());
    EXPECT_EQ(bind(socket_.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
    setenv("NOTIFY_SOCKET", ("@" + name).c_str(), 1);
  }
  ~FakeServiceManager() { unsetenv("NOTIFY_SOCKET"); }

  std::string next() const {
    std::array<char, 512> text{};
    const ssize_t size = recv(socket_.get(), text.data(), text.size(), MSG_DONTWAIT);
    return size > 0 ? std::string(text.data(), static_cast<size_t>(size)) : "";
  }

 private:
  host::FileDescriptor socket_{socket(AF_UNIX, SOCK_DGRAM, 0)};
};

TEST(ServiceManager, IsNotifiedOfStateChanges) {
  const FakeServiceManager manager;
  service_manager::notify_ready("2 sensors");
  EXPECT_EQ(manager.next(), "READY=1\nSTATUS=2 sensors");
  service_manager::notify_watchdog();
  EXPECT_EQ(manager.next(), "WATCHDOG=1");
  service_manager::notify_reloading();
  EXPECT_EQ(manager.next().substr(0, 26), "RELOADING=1\nMONOTONIC_USEC");
  service_manager::notify_stopping();
  EXPECT_EQ(manager.next(), "STOPPING=1");
}

TEST(ServiceManager, DoesNothingWithoutAServiceManager) {
  unsetenv("NOTIFY_SOCKET");
  service_manager::notify_ready("");
  service_manager::notify_watchdog();
  EXPECT_FALSE(service_manager::watchdog_timeout());
  EXPECT_TRUE(service_manager::inherited_sockets().empty());
}

TEST(ServiceManager, ReportsItsWatchdogTimeout) {
  setenv("WATCHDOG_USEC", "5000000", 1);
  setenv("WATCHDOG_PID", std::to_string(getpid()).c_str(), 1);
  EXPECT_EQ(service_manager::watchdog_timeout(), from_seconds(5));
  setenv("WATCHDOG_PID", "1", 1);
  EXPECT_FALSE(service_manager::watchdog_timeout());
  unsetenv("WATCHDOG_USEC");
  unsetenv("WATCHDOG_PID");
}

}  // namespace
}  // namespace infuse::daemon
