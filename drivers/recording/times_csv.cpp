#include "drivers/recording/times_csv.hpp"

#include <algorithm>
#include <array>
#include <fstream>

#include "drivers/measurement/median.hpp"
#include "drivers/recording/inside.hpp"
#include "drivers/recording/numbered_files.hpp"
#include "drivers/text/csv_reader.hpp"
#include "drivers/text/numbers.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::recording {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxRows = 10'000'000;

bool ends_with_newline(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(-1, std::ios::end);
  return file.get() == '\n';
}

std::string format_count(size_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::optional<Stamp> parse_optional(std::string_view field) {
  const auto ns = text::parse_integer(field);
  return ns ? std::optional(Stamp::from_ns(*ns)) : std::nullopt;
}

// Lists the files NNNNNN.<one of `extensions`> of a folder. `interpret` returns stamp and span of a
// row of its times.csv.
template <class Interpret>
Result<FileSequence> index_sequence(const fs::path& folder,
                                    const std::vector<std::string>& extensions,
                                    const Interpret& interpret) {
  const fs::path times_path = folder / "times.csv";
  const auto times = read_times(times_path);
  if (!times) return tl::unexpected(times.error());
  auto files = list_numbered_files(folder, extensions);
  if (!files) return tl::unexpected(files.error());

  FileSequence sequence;
  size_t without_time = 0, backward = 0;
  for (auto& [number, path] : *files) {
    if (number >= times->size()) {
      ++without_time;
      continue;
    }
    std::error_code ignored;
    if (fs::is_symlink(path, ignored) && !lies_inside(folder, path)) {
      return fail("is a link out of its folder", path.string(), "copy the file into the folder");
    }
    const auto [stamp, span] = interpret((*times)[number]);
    if (!sequence.entries.empty() && stamp < sequence.entries.back().stamp) ++backward;
    sequence.entries.push_back({stamp, span, number, std::move(path)});
  }
  if (without_time > 0) {
    sequence.notes.push_back(
        {format_count(without_time, "file") + " beyond the last row of times.csv", folder.string(),
         "they are ignored"});
  }
  if (sequence.entries.size() < times->size()) {
    sequence.notes.push_back({format_count(times->size() - sequence.entries.size(), "row") +
                                  " of times.csv without a file",
                              folder.string(), "treated as lost frames"});
  }
  if (backward > 0) {
    sequence.notes.push_back(
        {"the stamps decrease " + format_count(backward, "time"), times_path.string(), {}});
  }
  return sequence;
}

// Median of the time from one sweep to the next, up to `kMaxTurn`; 0 if there is none.
Duration usual_step(const std::vector<SequenceEntry>& entries) {
  std::vector<Duration> steps;
  for (size_t i = 1; i < entries.size(); ++i) {
    const Duration step = entries[i].stamp - entries[i - 1].stamp;
    if (step > Duration::zero() && step <= kMaxTurn) steps.push_back(step);
  }
  if (steps.empty()) return Duration::zero();
  return median(steps);
}

}  // namespace

Result<std::vector<TimesRow>> read_times(const fs::path& path) {
  static constexpr std::array<text::CsvColumn, 3> kColumns = {
      {{"stamp_ns"}, {"end_ns", false}, {"exposure_ns", false}}};
  auto csv = text::CsvReader::open(path, kColumns);
  if (!csv) return tl::unexpected(csv.error());
  std::vector<TimesRow> rows;
  std::array<std::string_view, 3> fields;
  while (csv->next(fields)) {
    const auto ns = text::parse_integer(fields[0]);
    // Skipping a row would shift all that follow. Only the last one may be invalid, if it was
    // truncated by a power cut.
    if (!ns) {
      const std::string where = csv->where();
      if (!ends_with_newline(path) && !csv->next(fields)) break;
      return fail("the stamp is not an integer of nanoseconds", where);
    }
    if (rows.size() == kMaxRows) return fail("has more than ten million rows", path.string());
    rows.push_back({Stamp::from_ns(*ns), parse_optional(fields[1]), parse_optional(fields[2])});
  }
  return rows;
}

Result<void> write_times(const fs::path& path, const std::vector<TimesRow>& rows,
                         const std::vector<std::string>& sources) {
  const auto any = [&](auto member) {
    return std::any_of(rows.begin(), rows.end(),
                       [&](const TimesRow& row) { return (row.*member).has_value(); });
  };
  const bool ends = any(&TimesRow::end), exposures = any(&TimesRow::exposure);
  std::string text = "stamp_ns";
  text += ends ? ",end_ns" : "";
  text += exposures ? ",exposure_ns" : "";
  text += sources.empty() ? "\n" : ",source\n";
  const auto append = [&](const std::optional<Stamp>& stamp) {
    text += ',';
    if (stamp) text.append(std::to_string(stamp->ns()));
  };
  for (size_t i = 0; i < rows.size(); ++i) {
    text += std::to_string(rows[i].stamp.ns());
    if (ends) append(rows[i].end);
    if (exposures) append(rows[i].exposure);
    if (i < sources.size()) text.append(",").append(sources[i]);
    text += '\n';
  }
  return text::write_text(path, text);
}

Result<void> write_times(const fs::path& path, const std::vector<Stamp>& stamps) {
  std::vector<TimesRow> rows;
  for (const Stamp stamp : stamps) rows.push_back({.stamp = stamp});
  return write_times(path, rows);
}

Result<FileSequence> index_sweeps(const fs::path& folder) {
  size_t implausible = 0;
  auto sequence = index_sequence(folder, {".bin", ".pcd"}, [&](const TimesRow& row) {
    const Duration span = row.end ? *row.end - row.stamp : Duration::zero();
    const bool plausible = span > Duration::zero() && span <= kMaxTurn;
    implausible += row.end && !plausible ? 1 : 0;
    return std::pair(row.stamp, plausible ? span : Duration::zero());
  });
  if (!sequence) return sequence;
  const Duration usual = usual_step(sequence->entries);
  for (SequenceEntry& entry : sequence->entries) {
    if (entry.span == Duration::zero()) entry.span = usual;
  }
  if (implausible > 0) {
    sequence->notes.push_back(
        {format_count(implausible, "sweep") + " whose end is not within 2 s after its stamp",
         (folder / "times.csv").string(), "the usual time between two sweeps is used instead"});
  }
  return sequence;
}

Result<FileSequence> index_images(const fs::path& folder, Duration stamp_delay) {
  return index_sequence(folder, {".png", ".jpg"}, [&](const TimesRow& row) {
    return std::pair(row.exposure.value_or(row.stamp - stamp_delay), Duration::zero());
  });
}

}  // namespace infuse::recording
