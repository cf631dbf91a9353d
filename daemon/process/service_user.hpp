#pragma once

#include <string>

#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// User that the service runs as.
inline constexpr const char* kServiceUser = "infuse";

/// Gives up root for this user, with its groups. Returns true if so; false if this process is not
/// root's or there is no such user. Errors: it is refused.
Result<bool> become_user(const std::string& name);

}  // namespace infuse::daemon
