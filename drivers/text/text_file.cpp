#include "drivers/text/text_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace infuse::text {
namespace {

struct Close {
  void operator()(FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<FILE, Close>;

}  // namespace

Result<std::string> read_text(const std::filesystem::path& path, size_t max_bytes) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return fail("is a folder", path.string());
  const File file(std::fopen(path.c_str(), "rbe"));
  if (!file) return fail(std::string("cannot be opened: ") + std::strerror(errno), path.string());
  std::string text;
  for (;;) {
    constexpr size_t kChunkBytes = 1 << 16;
    const size_t old_size = text.size();
    text.resize(old_size + kChunkBytes);
    const size_t bytes_read = std::fread(text.data() + old_size, 1, kChunkBytes, file.get());
    text.resize(old_size + bytes_read);
    if (text.size() > max_bytes)
      return fail("is longer than " + std::to_string(max_bytes) + " bytes", path.string());
    if (bytes_read < kChunkBytes) break;
  }
  if (std::ferror(file.get()) != 0)
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
