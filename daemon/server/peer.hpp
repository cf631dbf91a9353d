#pragma once

#include <sys/types.h>

#include <optional>

namespace infuse::daemon {

/// Who is at the other end of a Unix socket, as the kernel says.
struct Peer {
  pid_t process = 0;
  uid_t user = 0;
};

/// SO_PEERCRED of a connected socket; nothing where it has none (TCP).
std::optional<Peer> peer_of(int socket);

}  // namespace infuse::daemon
