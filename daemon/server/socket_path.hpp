#pragma once

#include <filesystem>
#include <vector>

namespace infuse::daemon {

/// Where the daemon's socket is when nobody says otherwise, in the order in which a client looks:
/// the user's own (`$XDG_RUNTIME_DIR/infused.sock`, where a replay listens), then the service's
/// (`/run/infuse/infused.sock`).
std::vector<std::filesystem::path> default_socket_paths();

}  // namespace infuse::daemon
