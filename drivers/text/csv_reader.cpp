#include "drivers/text/csv_reader.hpp"

#include <algorithm>

namespace infuse::text {
namespace {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

// Calls `use(index, field)` for each field of a row.
template <class Use>
void for_each_field(std::string_view row, const Use& use) {
  for (size_t index = 0;; ++index) {
    const size_t comma = row.find(',');
    use(index, trimmed(row.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    row.remove_prefix(comma + 1);
  }
}

}  // namespace

Result<CsvReader> CsvReader::open(const std::filesystem::path& path,
                                  std::span<const CsvColumn> columns) {
  auto lines = LineReader::open(path);
  if (!lines) return tl::unexpected(lines.error());
  CsvReader reader(std::move(*lines), path.string());
  reader.positions_.assign(columns.size(), std::string_view::npos);
  std::string_view header;
  reader.lines_.next(header);
  for_each_field(header, [&](size_t index, std::string_view name) {
    for (size_t i = 0; i < columns.size(); ++i) {
      if (columns[i].name == name) reader.positions_[i] = index;
    }
  });
  for (size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].required && reader.positions_[i] == std::string_view::npos) {
      return fail("has no column '" + std::string(columns[i].name) + "'", path.string() + ":1",
                  "the first line must name the columns");
    }
  }
  return reader;
}

bool CsvReader::next(std::span<std::string_view> fields) {
  std::string_view row;
  do {
    if (!lines_.next(row)) return false;
  } while (row.empty() || row.front() == '#');
  std::fill(fields.begin(), fields.end(), std::string_view());
  for_each_field(row, [&](size_t index, std::string_view field) {
    for (size_t i = 0; i < positions_.size(); ++i) {
      if (positions_[i] == index) fields[i] = field;
    }
  });
  return true;
}

void CsvReader::reject(const std::string& why) {
  if (rejected_rows_++ == 0) first_rejection_ = Error{why, where(), {}};
}

void CsvReader::append_notes(std::vector<Error>& notes) const {
  if (rejected_rows_ > 0) {
    notes.push_back(first_rejection_);
    notes.back().hint = std::to_string(rejected_rows_) + " such lines were skipped";
  }
  if (lines_.too_long_lines() > 0) {
    notes.push_back(
        {std::to_string(lines_.too_long_lines()) + " overlong lines were skipped", file_, {}});
  }
}

std::string CsvReader::where() const { return file_ + ":" + std::to_string(lines_.line_number()); }

}  // namespace infuse::text
