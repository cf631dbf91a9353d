#include "drivers/recording/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "drivers/host/file_descriptor.hpp"
#include "drivers/host/system_error.hpp"

namespace infuse::recording {
namespace {

constexpr std::string_view kSuffix = ".XXXXXX";  // of temporary files, by mkostemp(3)

using host::fail_errno;
using host::FileDescriptor;

bool write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return true;
}

}  // namespace

Result<void> write_file_atomically(const std::filesystem::path& path,
                                   std::span<const std::byte> bytes, std::optional<mode_t> mode) {
  struct stat present {};
  const bool replaces = ::lstat(path.c_str(), &present) == 0;
  if (replaces && !S_ISREG(present.st_mode)) {
    return fail("is not a regular file, it is not replaced", path.string(),
                "name another file to write");
  }
  const mode_t kept = replaces ? present.st_mode & 07777 : 0644;
  std::string temporary = path.string() + std::string(kSuffix);
  const FileDescriptor file(::mkostemp(temporary.data(), O_CLOEXEC));
  if (!file) {
    return fail_errno("cannot be written", path.string(),
                      "does the folder exist, and is it writable?");
  }
  const bool succeeded = ::fchmod(file.get(), mode.value_or(kept)) == 0 &&
                         write_all(file.get(), bytes) && ::fsync(file.get()) == 0 &&
                         ::rename(temporary.c_str(), path.c_str()) == 0;
  if (!succeeded) {
    const int reason = errno;
    ::unlink(temporary.c_str());
    return fail_errno("cannot be written", path.string(), "is the disk full?", reason);
  }
  // Sync the folder's entry too; if that fails, the file is still complete.
  const FileDescriptor folder(
      ::open(path.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder) ::fsync(folder.get());
  return {};
}

std::string_view target_of_temporary(std::string_view name) {
  if (name.size() <= kSuffix.size()) return {};
  const size_t stem = name.size() - kSuffix.size();
  return name[stem] == kSuffix.front() ? name.substr(0, stem) : std::string_view();
}

}  // namespace infuse::recording
