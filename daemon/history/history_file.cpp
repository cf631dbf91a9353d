#include "daemon/history/history_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <sstream>

#include "drivers/host/file_descriptor.hpp"
#include "drivers/host/system_error.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

constexpr mode_t kHistoryMode = 0640;  // the group may read it

std::filesystem::path older(const std::filesystem::path& path) { return path.string() + ".1"; }

Result<host::FileDescriptor> open_to_append(const std::filesystem::path& path) {
  host::FileDescriptor file(
      ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, kHistoryMode));
  if (!file) return host::fail_errno("cannot be opened", path.string());
  ::fchmod(file.get(), kHistoryMode);  // independent of the umask
  return file;
}

/// Size of the file, bytes; 0 if it is not known.
off_t size_of(const host::FileDescriptor& file) {
  struct stat about {};
  return ::fstat(file.get(), &about) == 0 ? about.st_size : 0;
}

/// True if a crash has left a part of a line at the end.
bool ends_within_a_line(const host::FileDescriptor& file, off_t size) {
  char last = '\n';
  return size > 0 && ::pread(file.get(), &last, 1, size - 1) == 1 && last != '\n';
}

}  // namespace

Result<void> HistoryFile::append(std::string_view line) const {
  auto file = open_to_append(path_);
  if (!file) return tl::unexpected(file.error());
  off_t size = size_of(*file);
  if (size > 0 && static_cast<uint64_t>(size) + line.size() + 1 > max_bytes_) {
    std::error_code failed;
    std::filesystem::rename(path_, older(path_), failed);
    if (failed) return fail("cannot be renamed: " + failed.message(), path_.string());
    file = open_to_append(path_);
    if (!file) return tl::unexpected(file.error());
    size = 0;
  }
  std::string text;
  if (ends_within_a_line(*file, size)) text += '\n';
  text += line;
  text += '\n';
  if (::write(file->get(), text.data(), text.size()) == static_cast<ssize_t>(text.size())) {
    return {};
  }
  auto failed = host::fail_errno("cannot be written", path_.string());
  if (::ftruncate(file->get(), size) != 0) return failed;  // the part is closed by the next line
  return failed;
}

Result<std::vector<std::string>> read_history(const std::filesystem::path& path) {
  std::error_code failed;
  const std::filesystem::directory_iterator folder(path.parent_path(), failed);
  if (failed) {
    return fail("cannot be read: " + failed.message(), path.parent_path().string(),
                "the daemon's state directory is for root and the group infuse");
  }
  std::vector<std::string> lines;
  for (const std::filesystem::path& part : {older(path), path}) {
    std::error_code ignored;
    if (!std::filesystem::exists(part, ignored)) continue;
    const auto text = text::read_text(part, 4 * HistoryFile::kMaxBytes);
    if (!text) return tl::unexpected(text.error());
    std::istringstream stream(*text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
  }
  return lines;
}

}  // namespace infuse::daemon
