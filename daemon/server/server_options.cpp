#include "daemon/server/server_options.hpp"

#include <sys/un.h>

namespace infuse::daemon {

std::optional<std::string> ServerOptions::invalid() const {
  constexpr size_t kMaxPathLength = sizeof(sockaddr_un::sun_path) - 1;
  if (path.size() > kMaxPathLength) {
    return "path is longer than " + std::to_string(kMaxPathLength) +
           " bytes, the limit of a socket";
  }
  if (max_clients < 1 || max_clients > 10'000) return "max_clients must be between 1 and 10000";
  if (max_clients_per_user < 1 || max_clients_per_user > 10'000) {
    return "max_clients_per_user must be between 1 and 10000";
  }
  if (idle_timeout <= Duration::zero()) return "idle_timeout_s must be positive";
  if (queue_reports < 2 || queue_reports > 100'000) {
    return "queue_reports must be between 2 and 100000";
  }
  if (!(max_requests_hz >= 1 && max_requests_hz <= 1e6)) {
    return "max_requests_hz must be between 1 and 1000000";
  }
  return std::nullopt;
}

}  // namespace infuse::daemon
