#include "drivers/recording/times_csv.hpp"

#include <array>
#include <fstream>

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

}  // namespace

Result<std::vector<Stamp>> read_times(const fs::path& path) {
  static constexpr std::array<text::CsvColumn, 1> kColumns = {{{"stamp_ns"}}};
  auto csv = text::CsvReader::open(path, kColumns);
  if (!csv) return tl::unexpected(csv.error());
  std::vector<Stamp> stamps;
  std::array<std::string_view, 1> fields;
  while (csv->next(fields)) {
    const auto ns = text::parse_integer(fields[0]);
    // Skipping a row would shift all that follow. Only the last one may be invalid, if it was
    // truncated by a power cut.
    if (!ns) {
      const std::string where = csv->where();
      if (!ends_with_newline(path) && !csv->next(fields)) break;
      return fail("the stamp is not an integer of nanoseconds", where);
    }
    if (stamps.size() == kMaxRows) return fail("has more than ten million rows", path.string());
    stamps.push_back(Stamp::from_ns(*ns));
  }
  return stamps;
}

Result<void> write_times(const fs::path& path, const std::vector<Stamp>& stamps,
                         const std::vector<std::string>& sources) {
  std::string text = sources.empty() ? "stamp_ns\n" : "stamp_ns,source\n";
  for (size_t i = 0; i < stamps.size(); ++i) {
    text += std::to_string(stamps[i].ns());
    if (i < sources.size()) text.append(",").append(sources[i]);
    text += '\n';
  }
  return text::write_text(path, text);
}

Result<FileSequence> index_sequence(const fs::path& folder,
                                    const std::vector<std::string>& extensions) {
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
    const Stamp stamp = (*times)[number];
    if (!sequence.entries.empty() && stamp < sequence.entries.back().stamp) ++backward;
    sequence.entries.push_back({stamp, number, std::move(path)});
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

Result<FileSequence> index_images(const fs::path& folder) {
  return index_sequence(folder, {".png", ".jpg"});
}

}  // namespace infuse::recording
