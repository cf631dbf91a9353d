#include "drivers/text/text_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace infuse::text {

Result<File> open_regular_file(const std::filesystem::path& path) {
  // O_NONBLOCK: opening a pipe must not wait for who writes to it.
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (file < 0)
    return fail(std::string("cannot be opened: ") + std::strerror(errno), path.string());
  struct stat about {};
  const bool known = ::fstat(file, &about) == 0;
  if (known && S_ISREG(about.st_mode)) {
    if (std::FILE* opened = ::fdopen(file, "rb")) return File(opened);
  }
  ::close(file);
  return fail(known && S_ISDIR(about.st_mode) ? "is a folder" : "is not a regular file",
              path.string());
}

Result<std::string> read_text(const std::filesystem::path& path, size_t max_bytes) {
  const auto file = open_regular_file(path);
  if (!file) return tl::unexpected(file.error());
  return read_text(file->get(), path, max_bytes);
}

Result<std::string> read_text(std::FILE* file, const std::filesystem::path& path,
                              size_t max_bytes) {
  std::string text;
  for (;;) {
    constexpr size_t kChunkBytes = 1 << 16;
    const size_t old_size = text.size();
    text.resize(old_size + kChunkBytes);
    const size_t bytes_read = std::fread(text.data() + old_size, 1, kChunkBytes, file);
    text.resize(old_size + bytes_read);
    if (text.size() > max_bytes)
      return fail("is longer than " + std::to_string(max_bytes) + " bytes", path.string());
    if (bytes_read < kChunkBytes) break;
  }
  if (std::ferror(file) != 0)
    return fail(std::string("cannot be read: ") + std::strerror(errno), path.string());
  return text;
}

Result<void> write_text(const std::filesystem::path& path, std::string_view text) {
  File file(std::fopen(path.c_str(), "wbe"));
  if (!file) return fail(std::string("cannot be opened: ") + std::strerror(errno), path.string());
  const bool written = std::fwrite(text.data(), 1, text.size(), file.get()) == text.size();
  if (!written || std::fclose(file.release()) != 0) {
    return fail(std::string("cannot be written: ") + std::strerror(errno), path.string(),
                "is the disk full?");
  }
  return {};
}

}  // namespace infuse::text
