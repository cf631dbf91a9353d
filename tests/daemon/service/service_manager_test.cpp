#include "daemon/service/service_manager.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

namespace infuse::daemon {
namespace {

/// A service manager's end of NOTIFY_SOCKET.
class Manager {
 public:
  Manager() {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string name = "infuse-notify-" + std::to_string(getpid());
    name.copy(address.sun_path + 1, sizeof(address.sun_path) - 2);  // an abstract name
    const auto size = static_cast<socklen_t>(sizeof(sa_family_t) + 1 + name.size());
    EXPECT_EQ(bind(socket_.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
    setenv("NOTIFY_SOCKET", ("@" + name).c_str(), 1);
  }
  ~Manager() { unsetenv("NOTIFY_SOCKET"); }

  std::string next() const {
    std::array<char, 512> text{};
    const ssize_t size = recv(socket_.get(), text.data(), text.size(), MSG_DONTWAIT);
    return size > 0 ? std::string(text.data(), static_cast<size_t>(size)) : "";
  }

 private:
  receive::Descriptor socket_{socket(AF_UNIX, SOCK_DGRAM, 0)};
};

TEST(ServiceManager, IsToldWhatHappens) {
  const Manager manager;
  service_manager::ready("2 sensors");
  EXPECT_EQ(manager.next(), "READY=1\nSTATUS=2 sensors");
  service_manager::alive();
  EXPECT_EQ(manager.next(), "WATCHDOG=1");
  service_manager::reloading();
  EXPECT_EQ(manager.next().substr(0, 26), "RELOADING=1\nMONOTONIC_USEC");
  service_manager::stopping();
  EXPECT_EQ(manager.next(), "STOPPING=1");
}

TEST(ServiceManager, IsNothingWhereThereIsNone) {
  unsetenv("NOTIFY_SOCKET");
  service_manager::ready("");
  service_manager::alive();
  EXPECT_FALSE(service_manager::watchdog());
  EXPECT_TRUE(service_manager::take_sockets().empty());
}

TEST(ServiceManager, SaysHowOftenItWantsToHear) {
  setenv("WATCHDOG_USEC", "5000000", 1);
  setenv("WATCHDOG_PID", std::to_string(getpid()).c_str(), 1);
  EXPECT_EQ(service_manager::watchdog(), from_seconds(5));
  setenv("WATCHDOG_PID", "1", 1);
  EXPECT_FALSE(service_manager::watchdog());
  unsetenv("WATCHDOG_USEC");
  unsetenv("WATCHDOG_PID");
}

}  // namespace
}  // namespace infuse::daemon
