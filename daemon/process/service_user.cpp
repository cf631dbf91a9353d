#include "daemon/process/service_user.hpp"

#include <grp.h>
#include <pwd.h>
#include <unistd.h>

#include "drivers/host/system_error.hpp"

namespace infuse::daemon {

Result<bool> become_user(const std::string& name) {
  if (::geteuid() != 0) return false;
  const passwd* user = ::getpwnam(name.c_str());
  if (user == nullptr) return false;
  if (::initgroups(user->pw_name, user->pw_gid) != 0 || ::setgid(user->pw_gid) != 0 ||
      ::setuid(user->pw_uid) != 0) {
    return host::fail_errno("cannot become the user", name);
  }
  return true;
}

}  // namespace infuse::daemon
