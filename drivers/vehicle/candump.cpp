#include "drivers/vehicle/candump.hpp"

#include <charconv>

#include "drivers/text/quoted.hpp"
#include "drivers/text/stamp_text.hpp"

namespace infuse::vehicle {
namespace {

constexpr uint32_t kErrorBit = 0x20000000u;

tl::unexpected<Error> parse_error(const std::string& what, const char* hint = "") {
  return fail(what, "", hint);
}

using text::quoted;

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// Removes and returns the next run of non-space characters; empty at the end.
std::string_view next_word(std::string_view& rest) {
  while (!rest.empty() && is_space(rest.front())) rest.remove_prefix(1);
  size_t length = 0;
  while (length < rest.size() && !is_space(rest[length])) ++length;
  const std::string_view word = rest.substr(0, length);
  rest.remove_prefix(length);
  return word;
}

template <class Integer>
bool read_integer(std::string_view text, Integer& value, int base = 10) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return !text.empty() && error == std::errc() && end == text.data() + text.size();
}

/// Three hexadecimal digits are a standard identifier, eight an extended one or an error frame.
bool read_id(std::string_view text, CanFrame& frame) {
  uint32_t id = 0;
  if ((text.size() != 3 && text.size() != 8) || !read_integer(text, id, 16)) return false;
  if (text.size() == 3) {
    frame.id = id;
    return id <= 0x7FF;
  }
  frame.error = (id & kErrorBit) != 0;
  frame.extended = !frame.error;
  frame.id = id & 0x1FFFFFFFu;
  return id <= 0x3FFFFFFFu;
}

bool is_valid_length(size_t bytes) {
  return bytes <= 8 || bytes == 12 || bytes == 16 || bytes == 20 || bytes == 24 || bytes == 32 ||
         bytes == 48 || bytes == 64;
}

/// Parses "08FF", or with dots between the bytes; skips a raw length code after an underscore.
Result<CanFrame> parse_compact_data(CanFrame frame, std::string_view digits) {
  digits = digits.substr(0, digits.find('_'));
  const size_t limit = frame.fd ? 64 : 8;
  while (!digits.empty()) {
    if (digits.front() == '.') {
      digits.remove_prefix(1);
      continue;
    }
    if (frame.length >= limit)
      return parse_error("more than " + std::to_string(limit) + " bytes of data");
    if (digits.size() < 2 || !read_integer(digits.substr(0, 2), frame.data[frame.length], 16)) {
      return parse_error(quoted(digits) + " is not a whole number of bytes in hexadecimal");
    }
    ++frame.length;
    digits.remove_prefix(2);
  }
  if (!is_valid_length(frame.length)) {
    return parse_error("a CAN FD frame cannot have " + std::to_string(frame.length) + " bytes");
  }
  return frame;
}

/// Parses "260#08FF", "260##108FF", "260#R4".
Result<CanFrame> parse_compact(CanFrame frame, std::string_view word) {
  const size_t hash = word.find('#');
  if (!read_id(word.substr(0, hash), frame)) {
    return parse_error(quoted(word.substr(0, hash)) + " is not an identifier",
                       "3 hexadecimal digits, or 8 for an extended one");
  }
  std::string_view data = word.substr(hash + 1);
  if (data.starts_with('#')) {
    frame.fd = true;
    if (data.size() < 2 || !read_integer(data.substr(1, 1), frame.fd_flags, 16)) {
      return parse_error("CAN FD flags are missing after '##'");
    }
    return parse_compact_data(frame, data.substr(2));
  }
  if (data.starts_with('R')) {
    frame.remote = true;
    if (data.size() > 1 && (!read_integer(data.substr(1, 1), frame.length) || frame.length > 8)) {
      return parse_error("the length of the remote request is not in 0 ... 8");
    }
    return frame;
  }
  return parse_compact_data(frame, data);
}

/// Parses "260", then "[8]  08 FF ...": two digits between the brackets mean CAN FD.
Result<CanFrame> parse_columns(CanFrame frame, std::string_view id, std::string_view length,
                               std::string_view rest) {
  if (!read_id(id, frame)) {
    return parse_error(quoted(id) + " is not an identifier",
                       "3 hexadecimal digits, or 8 for an extended one");
  }
  unsigned bytes = 0;
  if (length.size() < 3 || length.back() != ']' ||
      !read_integer(length.substr(1, length.size() - 2), bytes)) {
    return parse_error(quoted(length) + " is not a length in brackets");
  }
  frame.fd = length.size() == 4;
  if (bytes > (frame.fd ? 64u : 8u) || !is_valid_length(bytes)) {
    return parse_error("a frame cannot have " + std::to_string(bytes) + " bytes");
  }
  frame.length = static_cast<uint8_t>(bytes);
  for (size_t i = 0; i < bytes; ++i) {
    const std::string_view word = next_word(rest);
    if (i == 0 && word == "remote") {
      frame.remote = true;
      return frame;
    }
    if (word.size() != 2 || !read_integer(word, frame.data[i], 16)) {
      return parse_error("byte " + std::to_string(i) + " of " + std::to_string(bytes) + " is " +
                         quoted(word));
    }
  }
  if (bytes == 0 && next_word(rest) == "remote") frame.remote = true;
  return frame;
}

}  // namespace

Result<CanFrame> parse_candump_line(std::string_view line) {
  CanFrame frame;
  std::string_view rest = line;
  while (!rest.empty() && is_space(rest.front())) rest.remove_prefix(1);
  if (rest.starts_with('(')) {
    const size_t close = rest.find(')');
    if (close == std::string_view::npos) return parse_error("the time is not closed by ')'");
    const std::string_view time = rest.substr(1, close - 1);
    const auto stamp = text::parse_stamp(time);
    if (!stamp || *stamp < Stamp()) {
      return parse_error(quoted(time) + " is not a time", "expected (seconds.microseconds)");
    }
    frame.stamp = *stamp;
    rest.remove_prefix(close + 1);
  }
  // Interface and direction come before the word that contains '#' or precedes '['.
  std::string_view previous;
  for (int words = 0; words < 6; ++words) {
    const std::string_view word = next_word(rest);
    if (word.empty()) break;
    if (word.find('#') != std::string_view::npos) return parse_compact(frame, word);
    if (word.starts_with('[')) return parse_columns(frame, previous, word, rest);
    if (words == 0) {
      std::string_view ahead = rest;
      if (!next_word(ahead).starts_with('[')) frame.set_interface(word);
    }
    previous = word;
  }
  return parse_error("no CAN frame in " + quoted(line),
                     "expected '(time) interface id#data' or 'interface id [length] data'");
}

std::string format_candump_line(const CanFrame& frame) {
  char text[64];
  const int64_t us = frame.stamp.ns() / 1000;
  const std::string_view interface = frame.interface_name();
  std::string line(text, static_cast<size_t>(std::snprintf(text, sizeof text, "(%010lld.%06lld) ",
                                                           static_cast<long long>(us / 1000000),
                                                           static_cast<long long>(us % 1000000))));
  line += interface.empty() ? "can0" : interface;
  const uint32_t id = frame.error ? frame.id | kErrorBit : frame.id;
  std::snprintf(text, sizeof text, frame.extended || frame.error ? " %08X#" : " %03X#", id);
  line += text;
  if (frame.remote) {
    line += 'R';
    return frame.length > 0 ? line += std::to_string(frame.length) : line;
  }
  if (frame.fd) {
    std::snprintf(text, sizeof text, "#%X", frame.fd_flags & 0xFu);
    line += text;
  }
  for (const uint8_t byte : frame.payload()) {
    std::snprintf(text, sizeof text, "%02X", byte);
    line += text;
  }
  return line;
}

std::optional<CanFrame> CandumpReader::read(std::string_view line) {
  ++lines_;
  const size_t begin = line.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos || line[begin] == '#') return std::nullopt;
  const auto frame = parse_candump_line(line);
  if (!frame) {
    report(frame.error());
    return std::nullopt;
  }
  ++frames_;
  if (frame->stamp < last_) {
    report({"time goes back by " + std::to_string(to_seconds(last_ - frame->stamp)) + " s", "",
            "the clock was set, or logs were joined out of order; the frame is used"});
  }
  last_ = frame->stamp;
  return *frame;
}

void CandumpReader::report(Error problem) {
  problem.where = name_ + ":" + std::to_string(lines_);
  problems_.add(std::move(problem));
}

}  // namespace infuse::vehicle
