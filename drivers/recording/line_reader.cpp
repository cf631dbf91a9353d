#include "drivers/recording/line_reader.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>

namespace infuse::recording {

Result<LineReader> LineReader::open(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return fail("is a folder", path.string());
  FILE* file = std::fopen(path.c_str(), "rbe");
  if (file == nullptr) {
    return fail(std::string("cannot be opened: ") + std::strerror(errno), path.string());
  }
  return LineReader(file);
}

bool LineReader::refill() {
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  const size_t got = std::fread(buffer_.data() + end_, 1, buffer_.size() - end_, file_.get());
  end_ += got;
  return got > 0;
}

bool LineReader::next(std::string_view& line) {
  bool passing_over = false;
  for (;;) {
    const std::string_view rest(buffer_.data() + begin_, end_ - begin_);
    const size_t length = rest.find('\n');
    const bool ends_here = length != std::string_view::npos;
    if (!ends_here && rest.size() <= kMaxLine && refill()) continue;
    if (!ends_here && rest.size() > kMaxLine) {
      passing_over = true;
      begin_ = end_;
      continue;
    }
    if (!ends_here && rest.empty() && !passing_over) return false;

    line = rest.substr(0, ends_here ? length : rest.size());
    begin_ += line.size() + (ends_here ? 1 : 0);
    ++number_;
    if (passing_over || line.size() > kMaxLine) {
      ++too_long_;
      passing_over = false;
      continue;
    }
    if (line.ends_with('\r')) line.remove_suffix(1);
    return true;
  }
}

}  // namespace infuse::recording
