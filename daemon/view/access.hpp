#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "daemon/config/view_settings.hpp"

namespace infuse::daemon {

/// What a request to the view says about itself. Fields that are missing are empty.
struct ViewRequest {
  std::string_view method, target, host, origin, cookie;
  int hosts = 1;  ///< number of Host fields
  bool upgrade = false;
};

/// Why a request is refused.
struct ViewRefusal {
  int status = 403;  ///< of HTTP
  const char* reason = "";

  bool operator==(const ViewRefusal&) const = default;
};

/// Cookie in which the browser keeps the token.
inline constexpr std::string_view kTokenCookie = "infuse_view";

/// Checks a request: only reads, only hosts that are addresses or localhost (a name in `Host` that
/// somebody else's server resolves to this address would let his pages read: DNS rebinding), only
/// pages of this server or of `allowed_origins`, and the token where one is set. Returns why it is
/// refused, or nothing.
std::optional<ViewRefusal> check_access(const ViewRequest& request, const ViewSettings& settings);

/// Path of a target, without the query.
std::string_view path_of(std::string_view target);

/// Value of `token` in the query of a target; empty if there is none.
std::string_view token_of(std::string_view target);

}  // namespace infuse::daemon
