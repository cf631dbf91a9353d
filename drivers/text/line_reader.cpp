#include "drivers/text/line_reader.hpp"

#include <algorithm>
#include <cstring>
#include <string>

namespace infuse::text {

Result<LineReader> LineReader::open(const std::filesystem::path& path) {
  auto file = open_regular_file(path);
  if (!file) return tl::unexpected(file.error());
  return LineReader(*std::move(file));
}

bool LineReader::refill() {
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  const size_t bytes_read =
      std::fread(buffer_.data() + end_, 1, buffer_.size() - end_, file_.get());
  end_ += bytes_read;
  return bytes_read > 0;
}

bool LineReader::next(std::string_view& line) {
  bool skipping = false;
  for (;;) {
    const std::string_view rest(buffer_.data() + begin_, end_ - begin_);
    const size_t length = rest.find('\n');
    const bool has_newline = length != std::string_view::npos;
    if (!has_newline && rest.size() <= kMaxLineBytes && refill()) continue;
    if (!has_newline && rest.size() > kMaxLineBytes) {
      skipping = true;
      begin_ = end_;
      continue;
    }
    if (!has_newline && rest.empty() && !skipping) return false;

    line = rest.substr(0, has_newline ? length : rest.size());
    begin_ += line.size() + (has_newline ? 1 : 0);
    ++line_number_;
    if (skipping || line.size() > kMaxLineBytes) {
      ++too_long_lines_;
      skipping = false;
      continue;
    }
    if (line.ends_with('\r')) line.remove_suffix(1);
    return true;
  }
}

}  // namespace infuse::text
