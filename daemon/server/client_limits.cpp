#include "daemon/server/client_limits.hpp"

#include <algorithm>

namespace infuse::daemon {

std::optional<std::string> refuse_client(const ClientUser& client,
                                         std::span<const ClientUser> connected,
                                         const ServerOptions& options) {
  const size_t places = options.max_clients + (client.is_owner ? kOwnerPlaces : 0);
  if (connected.size() >= places) {
    return "too many clients: " + std::to_string(connected.size());
  }
  if (client.is_owner) return std::nullopt;
  const auto same = std::count_if(connected.begin(), connected.end(), [&](const ClientUser& other) {
    return !other.is_owner && other.user == client.user;
  });
  if (static_cast<size_t>(same) < options.max_clients_per_user) return std::nullopt;
  const std::string user = client.user ? "user " + std::to_string(*client.user) : "TCP";
  return "too many clients of " + user + ": " + std::to_string(same);
}

double TokenBucket::level(ServerClock::time_point now) const {
  const double seconds = std::chrono::duration<double>(now - filled_).count();
  return std::min(tokens_ + seconds * rate_hz_, rate_hz_);
}

bool TokenBucket::take(ServerClock::time_point now) {
  tokens_ = level(now);
  filled_ = now;
  if (tokens_ < 1) return false;
  tokens_ -= 1;
  return true;
}

std::optional<std::string> RefusalLog::due_line(ServerClock::time_point now) {
  if (count_ == 0 || (last_line_ && now - *last_line_ < kPeriod)) return std::nullopt;
  last_line_ = now;
  const std::string clients =
      count_ == 1 ? "a client was" : std::to_string(count_) + " clients were";
  count_ = 0;
  return clients + " refused; " + last_reason_;
}

}  // namespace infuse::daemon
