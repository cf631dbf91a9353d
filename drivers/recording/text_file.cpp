#include "drivers/recording/text_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace infuse::recording {
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
    constexpr size_t kStep = 1 << 16;
    const size_t had = text.size();
    text.resize(had + kStep);
    const size_t got = std::fread(text.data() + had, 1, kStep, file.get());
    text.resize(had + got);
    if (text.size() > max_bytes)
      return fail("is longer than " + std::to_string(max_bytes) + " bytes", path.string());
    if (got < kStep) break;
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

}  // namespace infuse::recording
