#include "drivers/recording/append_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace infuse::recording {
namespace {

constexpr mode_t kFileMode = 0640;

}  // namespace

Result<AppendFile> AppendFile::create(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kFileMode);
  if (file < 0)
    return fail(std::string("cannot be created: ") + std::strerror(errno), path.string());
  ::fchmod(file, kFileMode);  // independent of the umask
  return AppendFile(path, file);
}

AppendFile::AppendFile(AppendFile&& other) noexcept
    : path_(std::move(other.path_)),
      file_(std::exchange(other.file_, -1)),
      buffer_(std::move(other.buffer_)),
      written_(other.written_) {}

AppendFile& AppendFile::operator=(AppendFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(file_, other.file_);
  std::swap(buffer_, other.buffer_);
  std::swap(written_, other.written_);
  return *this;
}

AppendFile::~AppendFile() {
  if (file_ < 0) return;
  static_cast<void>(flush());
  ::close(file_);
}

Result<void> AppendFile::flush() {
  std::string_view rest = buffer_;
  while (!rest.empty()) {
    const ssize_t written = ::write(file_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const int reason = errno;
      buffer_.clear();
      // Later appends continue from the new end.
      if (::ftruncate(file_, static_cast<off_t>(written_)) == 0) {
        ::lseek(file_, static_cast<off_t>(written_), SEEK_SET);
      }
      return fail(std::string("cannot be written: ") + std::strerror(reason), path_.string(),
                  "is the disk full?");
    }
    rest.remove_prefix(static_cast<size_t>(written));
  }
  written_ += buffer_.size();
  buffer_.clear();
  return {};
}

}  // namespace infuse::recording
