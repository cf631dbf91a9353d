#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/host/file_descriptor.hpp"
#include "drivers/measurement/stamp.hpp"

/// Notifications to systemd (sd_notify(3)) and its socket activation. Without a service manager
/// every notification is a no-op.
namespace infuse::daemon::service_manager {

/// Reports that the daemon is ready, with a status line.
void notify_ready(const std::string& status);
/// Sets the status line of `systemctl status`.
void notify_status(const std::string& status);
/// Feeds the watchdog; called when the pipeline has made progress.
void notify_watchdog();
/// Reports that the configuration is being reloaded; `notify_ready` ends it.
void notify_reloading();
/// Reports that the daemon is stopping.
void notify_stopping();

/// Watchdog timeout: the daemon is restarted if `notify_watchdog` is not called within it; nothing
/// if the watchdog is off.
std::optional<Duration> watchdog_timeout();

/// Listening Unix stream sockets inherited from the service manager. A second call returns none.
std::vector<host::FileDescriptor> inherited_sockets();

}  // namespace infuse::daemon::service_manager
