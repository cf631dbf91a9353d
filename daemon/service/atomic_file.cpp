#include "daemon/service/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>

#include "drivers/receive/file_descriptor.hpp"
#include "drivers/receive/system_error.hpp"

namespace infuse::daemon {
namespace {

using receive::FileDescriptor;

bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(file, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(static_cast<size_t>(written));
  }
  return true;
}

bool write_to_disk(const std::filesystem::path& path, std::string_view text) {
  constexpr mode_t kMode = 0640;
  const FileDescriptor file(
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, kMode));
  return file && write_all(file.get(), text) && fsync(file.get()) == 0;
}

}  // namespace

Result<void> write_atomically(const std::filesystem::path& path, std::string_view text) {
  const std::filesystem::path beside = path.string() + ".new";
  if (!write_to_disk(beside, text) || std::rename(beside.c_str(), path.c_str()) != 0) {
    const int number = errno;
    ::unlink(beside.c_str());
    return receive::fail_errno("cannot be written", path.string(), "", number);
  }
  // Sync the folder's entry too; if that fails, the file is still complete.
  const FileDescriptor folder(
      ::open(path.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder) fsync(folder.get());
  return {};
}

}  // namespace infuse::daemon
