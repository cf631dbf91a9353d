#include <algorithm>
#include <optional>

#include "drivers/recording/toml_table.hpp"

namespace infuse::recording {
namespace {

constexpr size_t kMaxText = 1 << 20;

bool is_ascii(char c) { return static_cast<unsigned char>(c) < 0x80; }

// Where a one-line string ends (its quote stands at `at`): behind the closing quote, or at the end
// of the line where that is missing.
size_t end_of_string(std::string_view text, size_t at) {
  const char quote = text[at++];
  for (; at < text.size() && text[at] != '\n'; ++at) {
    if (text[at] == '\\' && quote == '"') {
      ++at;
    } else if (text[at] == quote) {
      return at + 1;
    }
  }
  return std::min(at, text.size());
}

// The first byte beyond ASCII that is neither in a one-line string nor in a comment. Exact up to
// the first error of syntax, which ends the parsing anyway. A multi-line string looks here as an
// empty string, then text, then an empty string.
std::optional<size_t> find_stray(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  size_t at = text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
  std::string_view multi_line;  // the three quotes that end the string we are in
  while (at < text.size()) {
    const char c = text[at];
    const std::string_view three = text.substr(at, 3);
    if (!is_ascii(c)) return at;
    if (!multi_line.empty()) {
      const bool escaped = c == '\\' && multi_line == R"(""")";
      if (three == multi_line) {
        at += 3;
        for (int more = 0; more < 2 && at < text.size() && text[at] == multi_line[0]; ++more) ++at;
        multi_line = {};
      } else {
        // What a backslash protects is looked at all the same.
        if (escaped && at + 1 < text.size() && is_ascii(text[at + 1])) ++at;
        ++at;
      }
    } else if (three == R"(""")" || three == "'''") {
      multi_line = three;
      at += 3;
    } else if (c == '"' || c == '\'') {
      at = end_of_string(text, at);
    } else if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
    } else {
      ++at;
    }
  }
  return std::nullopt;
}

std::string place(const std::string& file, size_t line) {
  return std::string(file).append(":").append(std::to_string(line));
}

}  // namespace

Result<toml::table> parse_toml(std::string_view text, const std::string& file) {
  if (text.size() > kMaxText)
    return fail("is longer than " + std::to_string(kMaxText) + " bytes", file);
  if (const auto stray = find_stray(text)) {
    const auto line = std::count(text.begin(), text.begin() + static_cast<ptrdiff_t>(*stray), '\n');
    return fail("a character beyond ASCII outside a one-line string or a comment",
                place(file, static_cast<size_t>(line) + 1), "put it in quotes");
  }
  toml::parse_result parsed = toml::parse(text);
  if (!parsed) {
    return fail(std::string(parsed.error().description()),
                place(file, parsed.error().source().begin.line));
  }
  return std::move(parsed).table();
}

}  // namespace infuse::recording
