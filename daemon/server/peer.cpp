#include "daemon/server/peer.hpp"

#include <sys/socket.h>

namespace infuse::daemon {

std::optional<Peer> peer_of(int socket) {
  ucred credentials{};
  socklen_t size = sizeof(credentials);
  if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) return std::nullopt;
  if (credentials.pid == 0) return std::nullopt;  // TCP
  return Peer{credentials.pid, credentials.uid};
}

}  // namespace infuse::daemon
