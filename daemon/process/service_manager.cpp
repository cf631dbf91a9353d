#include "daemon/process/service_manager.hpp"

#include <sys/socket.h>
#include <systemd/sd-daemon.h>

#include <ctime>

namespace infuse::daemon::service_manager {

void notify_ready(const std::string& status) {
  sd_notify(0, ("READY=1\nSTATUS=" + status).c_str());
}

void notify_status(const std::string& status) { sd_notify(0, ("STATUS=" + status).c_str()); }

void notify_watchdog() { sd_notify(0, "WATCHDOG=1"); }

void notify_reloading() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const int64_t us = int64_t{now.tv_sec} * 1'000'000 + now.tv_nsec / 1000;
  sd_notify(0, ("RELOADING=1\nMONOTONIC_USEC=" + std::to_string(us)).c_str());
}

void notify_stopping() { sd_notify(0, "STOPPING=1"); }

std::optional<Duration> watchdog_timeout() {
  uint64_t us = 0;
  if (sd_watchdog_enabled(0, &us) <= 0) return std::nullopt;
  return std::chrono::microseconds(us);
}

std::vector<host::FileDescriptor> inherited_sockets() {
  std::vector<host::FileDescriptor> sockets;
  const int count =
      sd_listen_fds(1);  // 1: unset the environment, so that child processes do not inherit it
  for (int i = 0; i < count; ++i) {
    host::FileDescriptor socket(SD_LISTEN_FDS_START + i);
    if (sd_is_socket(socket.get(), AF_UNIX, SOCK_STREAM, 1) > 0) {
      sockets.push_back(std::move(socket));
    }
  }
  return sockets;
}

}  // namespace infuse::daemon::service_manager
