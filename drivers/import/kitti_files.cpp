#include "drivers/import/kitti_files.hpp"

#include <algorithm>

#include "drivers/measurement/median.hpp"
#include "drivers/text/line_reader.hpp"
#include "drivers/text/numbers.hpp"
#include "drivers/text/stamp_text.hpp"

namespace infuse::importers {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxLines = 10'000'000;

}  // namespace

NumberedFiles list_files(const fs::path& folder, const std::string& extension) {
  return recording::list_numbered_files(folder, {extension}).value_or(NumberedFiles());
}

NumberedFiles list_images(const fs::path& folder) {
  return recording::list_numbered_files(folder, {".png", ".jpg", ".jpeg"})
      .value_or(NumberedFiles());
}

Result<std::vector<std::optional<Stamp>>> read_kitti_times(const fs::path& path) {
  auto lines = text::LineReader::open(path);
  if (!lines) return tl::unexpected(lines.error());
  std::vector<std::optional<Stamp>> times;
  std::string_view line;
  while (lines->next(line)) {
    while (line.ends_with(' ')) line.remove_suffix(1);
    if (line.empty() && times.size() < kMaxLines) {
      times.emplace_back();
      continue;
    }
    const auto stamp = text::parse_stamp(line);
    if (!stamp || *stamp < Stamp() || times.size() == kMaxLines) {
      return fail("is not a time", path.string() + ":" + std::to_string(lines->line_number()),
                  "expected seconds or 2011-09-26 13:02:25.964389445");
    }
    times.push_back(*stamp);
  }
  return times;
}

Duration usual_period(const std::vector<std::optional<Stamp>>& times) {
  constexpr Duration kMaxPeriod{1'000'000'000};
  std::vector<Duration> steps;
  for (size_t k = 1; k < times.size(); ++k) {
    if (!times[k] || !times[k - 1]) continue;
    const Duration step = *times[k] - *times[k - 1];
    if (step > Duration::zero() && step <= kMaxPeriod) steps.push_back(step);
  }
  if (steps.empty()) return Duration::zero();
  return median(steps);
}

std::vector<StampedFile> assign_times(const NumberedFiles& files,
                                      const std::vector<std::optional<Stamp>>& times,
                                      std::vector<Error>& notes) {
  std::vector<StampedFile> result;
  size_t without_time = 0;
  for (const auto& [number, path] : files) {
    if (number < times.size() && times[number]) {
      result.push_back({{.stamp = *times[number]}, path, number});
    } else if (without_time++ == 0) {
      notes.push_back({"has no stamp", path.string(), {}});
    }
  }
  if (without_time > 0)
    notes.back().hint = std::to_string(without_time) + " such files are skipped";
  return result;
}

Result<std::vector<std::vector<double>>> read_number_lines(const fs::path& path, size_t count) {
  auto lines = text::LineReader::open(path);
  if (!lines) return tl::unexpected(lines.error());
  std::vector<std::vector<double>> rows;
  std::string_view line;
  while (lines->next(line)) {
    if (line.empty()) continue;
    auto numbers = text::parse_numbers(line);
    if (!numbers || numbers->size() != count || rows.size() == kMaxLines) {
      return fail("is not " + std::to_string(count) + " numbers",
                  path.string() + ":" + std::to_string(lines->line_number()));
    }
    rows.push_back(std::move(*numbers));
  }
  return rows;
}

}  // namespace infuse::importers
