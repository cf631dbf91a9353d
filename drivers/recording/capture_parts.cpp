#include "drivers/recording/capture_parts.hpp"

#include <glob.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>

namespace infuse::recording {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kDigits = "0123456789";

/// The name of a capture: what all parts of a recording share, and the number of this part.
struct PartName {
  std::string recording;
  std::optional<uint64_t> number;
};

std::optional<uint64_t> parse_number(std::string_view digits) {
  uint64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return value;
}

/// Removes the digits at the end of `text`, at least `min_digits`, and returns them; else nothing.
std::optional<std::string_view> strip_digits(std::string_view& text, size_t min_digits) {
  const size_t last = text.find_last_not_of(kDigits);
  const size_t begin = last == std::string_view::npos ? 0 : last + 1;
  if (text.size() - begin < min_digits) return std::nullopt;
  const std::string_view digits = text.substr(begin);
  text.remove_suffix(digits.size());
  return digits;
}

bool strip_suffix(std::string_view& text, std::string_view suffix) {
  if (!text.ends_with(suffix)) return false;
  text.remove_suffix(suffix.size());
  return true;
}

/// The number in "drive_00012_20260101120000", without the extension, as dumpcap writes it.
std::optional<PartName> parse_dumpcap_name(std::string_view stem, std::string_view extension) {
  constexpr size_t kStampDigits = 14;
  constexpr size_t kMinNumberDigits = 5;
  const auto stamp = strip_digits(stem, kStampDigits);
  if (!stamp || stamp->size() != kStampDigits || !strip_suffix(stem, "_")) return std::nullopt;
  const auto number = strip_digits(stem, kMinNumberDigits);
  if (!number || !strip_suffix(stem, "_")) return std::nullopt;
  return PartName{std::string(stem) + "_*" + std::string(extension), parse_number(*number)};
}

std::optional<PartName> parse_part_name(const std::string& file_name) {
  std::string_view name = file_name;
  if (!strip_suffix(name, ".gz")) strip_suffix(name, ".zst");
  std::string_view stem = name;
  const auto number = strip_digits(stem, 1);
  for (const std::string_view extension : {".pcap", ".pcapng", ".cap"}) {
    const std::string_view recording = stem;
    if (!strip_suffix(stem, extension)) continue;
    if (!number) {
      if (auto dumpcap = parse_dumpcap_name(stem, extension)) return dumpcap;
    }
    return PartName{std::string(recording), number ? parse_number(*number) : std::nullopt};
  }
  return std::nullopt;
}

struct Part {
  PartName name;
  fs::path path;
};

std::vector<Part> list_parts(const fs::path& folder) {
  std::vector<Part> parts;
  std::error_code error;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end;
       !error && entry != end; entry.increment(error)) {
    auto name = parse_part_name(entry->path().filename());
    std::error_code ignored;
    if (!name || !entry->is_regular_file(ignored)) continue;
    parts.push_back({*std::move(name), folder / entry->path().filename()});
  }
  std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
    return std::tie(a.name.recording, a.name.number, a.path) <
           std::tie(b.name.recording, b.name.number, b.path);
  });
  return parts;
}

/// Recordings of a folder, each as its parts in order. Two files of one number (x.pcap, x.pcap.gz)
/// are copies: then each file is a recording.
std::vector<std::vector<fs::path>> list_recordings(const fs::path& folder) {
  const std::vector<Part> parts = list_parts(folder);
  std::vector<std::vector<fs::path>> recordings;
  for (size_t i = 0, end = 0; i < parts.size(); i = end) {
    bool copies = false;
    for (end = i + 1; end < parts.size(); ++end) {
      if (parts[end].name.recording != parts[i].name.recording) break;
      copies = copies || parts[end].name.number == parts[end - 1].name.number;
    }
    for (size_t part = i; part < end; ++part) {
      if (part == i || copies) recordings.emplace_back();
      recordings.back().push_back(parts[part].path);
    }
  }
  return recordings;
}

/// `file` with the parts that follow it, if it is the first of its recording; else alone.
std::vector<fs::path> parts_from(const fs::path& file) {
  for (std::vector<fs::path>& recording : list_recordings(file.parent_path())) {
    if (recording.front().filename() == file.filename()) return std::move(recording);
  }
  return {file};
}

Result<std::vector<fs::path>> match(const fs::path& pattern) {
  glob_t found{};
  const int status = glob(pattern.c_str(), 0, nullptr, &found);
  std::vector<fs::path> paths;
  std::error_code ignored;
  for (size_t i = 0; status == 0 && i < found.gl_pathc; ++i) {
    if (fs::is_regular_file(found.gl_pathv[i], ignored)) paths.emplace_back(found.gl_pathv[i]);
  }
  globfree(&found);
  if (paths.empty()) return fail("no file matches this pattern", pattern.string());
  return paths;
}

}  // namespace

std::vector<fs::path> list_captures(const fs::path& folder) {
  std::vector<fs::path> captures;
  for (const auto& recording : list_recordings(folder)) captures.push_back(recording.front());
  return captures;
}

bool is_capture_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored) && !fs::exists(path / "drive.toml", ignored) &&
         !list_parts(path).empty();
}

Result<std::vector<fs::path>> find_capture_parts(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    std::vector<fs::path> files;
    for (const Part& part : list_parts(path)) files.push_back(part.path);
    if (files.empty()) {
      return fail("holds no captures", path.string(), "expected files named *.pcap or *.pcapng");
    }
    return files;
  }
  if (fs::exists(path, ignored)) return parts_from(path);
  if (path.native().find_first_of("*?[") != std::string::npos) return match(path);
  return std::vector<fs::path>{path};
}

}  // namespace infuse::recording
