#pragma once

#include <filesystem>
#include <vector>

namespace infuse::daemon {

/// Returns the default paths of the daemon's socket, in the order in which a client tries them: the
/// user's (`$XDG_RUNTIME_DIR/infused.sock`, used by a replay), then the service's
/// (`/run/infuse/infused.sock`).
std::vector<std::filesystem::path> default_socket_paths();

}  // namespace infuse::daemon
