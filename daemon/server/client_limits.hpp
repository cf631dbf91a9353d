#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "daemon/server/server_options.hpp"

namespace infuse::daemon {

using ServerClock = std::chrono::steady_clock;

/// User of a client.
struct ClientUser {
  std::optional<uid_t> user;  ///< not known over TCP: all these count as one user
  bool is_owner = false;      ///< the daemon's own user, or root
};

/// Number of connections beyond `max_clients` that are kept for the owner.
inline constexpr uint32_t kOwnerPlaces = 8;

/// Returns why a further client is refused, given those that are connected, or nothing.
std::optional<std::string> refuse_client(const ClientUser& client,
                                         std::span<const ClientUser> connected,
                                         const ServerOptions& options);

/// Permits events at a rate, after a burst of one second's.
class TokenBucket {
 public:
  TokenBucket(double rate_hz, ServerClock::time_point now)
      : rate_hz_(rate_hz), tokens_(rate_hz), filled_(now) {}

  /// True if one more event at `now` is permitted.
  bool take(ServerClock::time_point now);

  /// True if it holds all of its tokens at `now`.
  bool full(ServerClock::time_point now) const { return level(now) >= rate_hz_; }

 private:
  double level(ServerClock::time_point now) const;

  double rate_hz_;
  double tokens_;
  ServerClock::time_point filled_;
};

/// Sums up refused clients, so that they do not fill the log.
class RefusalLog {
 public:
  /// Time between two lines.
  static constexpr std::chrono::seconds kPeriod{60};

  /// Notes a refusal.
  void add(const std::string& reason) {
    ++count_;
    last_reason_ = reason;
  }

  /// Returns the line that is due at `now`, or nothing: the first refusal's at once, then one per
  /// period as long as clients are refused.
  std::optional<std::string> due_line(ServerClock::time_point now);

 private:
  uint64_t count_ = 0;  // since the last line
  std::string last_reason_;
  std::optional<ServerClock::time_point> last_line_;
};

}  // namespace infuse::daemon
