#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/stamp.hpp"
#include "drivers/receive/file_descriptor.hpp"

/// What is said to systemd (sd_notify(3)). Each is nothing where no service manager listens.
namespace infuse::daemon::service_manager {

/// The daemon can be asked.
void notify_ready(const std::string& status);
/// A line for `systemctl status`.
void notify_status(const std::string& status);
/// The pipeline has made progress: feeds the watchdog.
void notify_watchdog();
/// The configuration is read again; `ready` ends it.
void notify_reloading();
void notify_stopping();

/// How long it waits for `alive` before it restarts the daemon; nothing: it does not.
std::optional<Duration> watchdog_timeout();

/// The Unix stream sockets that it listens to for the daemon, handed over once.
std::vector<receive::FileDescriptor> inherited_sockets();

}  // namespace infuse::daemon::service_manager
