#include "drivers/recording/append_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "drivers/host/system_error.hpp"

namespace infuse::recording {
namespace {

constexpr mode_t kFileMode = 0640;

}  // namespace

Result<AppendFile> AppendFile::create(const std::filesystem::path& path) {
  host::FileDescriptor file(
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kFileMode));
  if (!file) return host::fail_errno("cannot be created", path.string());
  ::fchmod(file.get(), kFileMode);  // independent of the umask
  return AppendFile(path, std::move(file));
}

AppendFile& AppendFile::operator=(AppendFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(file_, other.file_);
  std::swap(buffer_, other.buffer_);
  std::swap(written_, other.written_);
  return *this;
}

AppendFile::~AppendFile() {
  if (file_) static_cast<void>(flush());
}

Result<void> AppendFile::flush() {
  std::string_view rest = buffer_;
  while (!rest.empty()) {
    const ssize_t written = ::write(file_.get(), rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const int reason = errno;
      buffer_.clear();
      // Later appends continue from the new end.
      if (::ftruncate(file_.get(), static_cast<off_t>(written_)) == 0) {
        ::lseek(file_.get(), static_cast<off_t>(written_), SEEK_SET);
      }
      return host::fail_errno("cannot be written", path_.string(), "is the disk full?", reason);
    }
    rest.remove_prefix(static_cast<size_t>(written));
  }
  written_ += buffer_.size();
  buffer_.clear();
  return {};
}

}  // namespace infuse::recording
