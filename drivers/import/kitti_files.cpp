#include "drivers/import/kitti_files.hpp"

#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <fstream>

#include "drivers/recording/number_list.hpp"
#include "drivers/text/csv_reader.hpp"
#include "drivers/text/line_reader.hpp"

namespace infuse::recording {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxLines = 10'000'000;

// "2011-09-26 13:02:25.964389445"
std::optional<Stamp> parse_date(std::string_view text) {
  if (text.size() < 19 || text[4] != '-' || text[7] != '-' || text[10] != ' ' || text[13] != ':') {
    return std::nullopt;
  }
  const auto part = [&](size_t at, size_t length) {
    return static_cast<int>(parse_integer(text.substr(at, length)).value_or(-1));
  };
  const std::chrono::year_month_day day(std::chrono::year(part(0, 4)),
                                        std::chrono::month(static_cast<unsigned>(part(5, 2))),
                                        std::chrono::day(static_cast<unsigned>(part(8, 2))));
  const int hour = part(11, 2), minute = part(14, 2);
  const auto seconds = parse_seconds(text.substr(17));
  const bool valid = day.ok() && hour >= 0 && hour < 24 && minute >= 0 && minute < 60 &&
                     text[16] == ':' && seconds && *seconds < Stamp() + std::chrono::seconds(61);
  if (!valid) return std::nullopt;
  const Duration midnight = std::chrono::sys_days(day).time_since_epoch();
  return *seconds + midnight + std::chrono::hours(hour) + std::chrono::minutes(minute);
}

}  // namespace

std::map<size_t, fs::path> list_numbered_files(const fs::path& folder,
                                               const std::string& extension) {
  std::map<size_t, fs::path> files;
  std::error_code failed;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end;
       entry.increment(failed)) {
    const fs::path& path = entry->path();
    const std::string stem = path.stem().string();
    if (path.extension() != extension || stem.size() > 18) continue;
    const auto number = parse_integer(stem);
    if (number && *number >= 0) files[static_cast<size_t>(*number)] = path;
  }
  return files;
}

Result<std::vector<Stamp>> read_kitti_times(const fs::path& path) {
  auto lines = LineReader::open(path);
  if (!lines) return tl::unexpected(lines.error());
  std::vector<Stamp> times;
  std::string_view line;
  while (lines->next(line)) {
    while (line.ends_with(' ')) line.remove_suffix(1);
    if (line.empty()) continue;
    auto stamp = parse_seconds(line);
    if (!stamp) stamp = parse_date(line);
    if (!stamp || times.size() == kMaxLines) {
      return fail("is not a time", path.string() + ":" + std::to_string(lines->line_number()),
                  "expected seconds or 2011-09-26 13:02:25.964389445");
    }
    times.push_back(*stamp);
  }
  return times;
}

std::vector<StampedFile> assign_times(const std::map<size_t, fs::path>& files,
                                      const std::vector<Stamp>& times, std::vector<Error>& notes) {
  std::vector<StampedFile> result;
  size_t without_time = 0;
  for (const auto& [number, path] : files) {
    if (number < times.size()) {
      result.push_back({times[number], path});
    } else if (without_time++ == 0) {
      notes.push_back({"has no stamp", path.string(), {}});
    }
  }
  if (without_time > 0)
    notes.back().hint = std::to_string(without_time) + " such files are skipped";
  return result;
}

Result<std::vector<std::vector<double>>> read_number_lines(const fs::path& path, size_t count) {
  auto lines = LineReader::open(path);
  if (!lines) return tl::unexpected(lines.error());
  std::vector<std::vector<double>> rows;
  std::string_view line;
  while (lines->next(line)) {
    if (line.empty()) continue;
    auto numbers = parse_numbers(line);
    if (!numbers || numbers->size() != count || rows.size() == kMaxLines) {
      return fail("is not " + std::to_string(count) + " numbers",
                  path.string() + ":" + std::to_string(lines->line_number()));
    }
    rows.push_back(std::move(*numbers));
  }
  return rows;
}

}  // namespace infuse::recording
