#include "daemon/process/state_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>

namespace infuse::daemon {

Result<host::FileDescriptor> lock_state(const std::filesystem::path& folder) {
  host::FileDescriptor file(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!file || ::flock(file.get(), LOCK_EX | LOCK_NB) == 0) return file;
  return fail("another infused uses this state directory", folder.string(),
              "end it, or give this one another STATE_DIRECTORY");
}

}  // namespace infuse::daemon
