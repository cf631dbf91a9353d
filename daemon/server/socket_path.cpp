#include "daemon/server/socket_path.hpp"

#include <cstdlib>

namespace infuse::daemon {

std::vector<std::filesystem::path> default_socket_paths() {
  std::vector<std::filesystem::path> paths;
  if (const char* runtime = std::getenv("XDG_RUNTIME_DIR"); runtime != nullptr && *runtime == '/') {
    paths.push_back(std::filesystem::path(runtime) / "infused.sock");
  }
  paths.emplace_back("/run/infuse/infused.sock");
  return paths;
}

}  // namespace infuse::daemon
