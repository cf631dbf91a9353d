#pragma once

#include <sys/types.h>

#include <optional>

namespace infuse::daemon {

/// Process and user at the other end of a Unix socket, as reported by the kernel.
struct Peer {
  pid_t process = 0;
  uid_t user = 0;
};

/// Returns SO_PEERCRED of a connected socket, or nothing (TCP).
std::optional<Peer> peer_of(int socket);

}  // namespace infuse::daemon
