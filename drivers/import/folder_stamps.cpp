#include "drivers/import/folder_stamps.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "drivers/recording/toml_table.hpp"
#include "drivers/text/numbers.hpp"
#include "drivers/text/stamp_text.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::importers {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxStampBytes = size_t{256} << 20;
constexpr size_t kMaxListedFiles = 10'000'000;
constexpr size_t kNoColumn = std::string::npos;
constexpr std::string_view kTenDigits = "0123456789";
constexpr Stamp kLatestStamp = Stamp::from_ns(4'260'000'000'000'000'000);  // in 2104

const std::map<std::string, size_t, std::less<>>& unit_digits() {
  static const std::map<std::string, size_t, std::less<>> kDigits = {
      {"s", 0}, {"ms", 3}, {"us", 6}, {"ns", 9}};
  return kDigits;
}

/// Columns may be given by name or by number from 1.
void read_column(recording::TomlTable& table, std::string_view key, std::string& column) {
  const toml::node* node = table.node(key);
  if (node != nullptr && node->is_integer()) {
    int64_t number = 0;
    table.read(key, 1, 1000, number);
    column = std::to_string(number);
  } else {
    table.read(key, column);
  }
}

void read_start(recording::TomlTable& table, std::optional<Stamp>& start) {
  const toml::node* node = table.node("start");
  if (node == nullptr) return;
  const auto* text = node->as_string();
  start = text == nullptr ? std::nullopt : parse_stamp_in(text->get(), "s");
  if (!start) {
    table.report_error("start", "start must be a date and time in UTC, or seconds, in quotes",
                       "for example \"2018-08-02 16:14:48.25\"");
  }
}

char separator_of(std::string_view line) {
  for (const char separator : {',', ';', '\t'}) {
    if (line.find(separator) != std::string_view::npos) return separator;
  }
  return ' ';
}

std::string_view trim(std::string_view text) {
  const auto is_outer = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '"'; };
  while (!text.empty() && is_outer(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_outer(text.back())) text.remove_suffix(1);
  return text;
}

/// Splits a line; at blanks, a date and its time stay together.
void split_fields(std::string_view line, char separator, std::vector<std::string_view>& fields) {
  fields.clear();
  if (separator != ' ') {
    for (size_t at = 0; at <= line.size();) {
      const size_t end = std::min(line.find(separator, at), line.size());
      fields.push_back(trim(line.substr(at, end - at)));
      at = end + 1;
    }
    return;
  }
  for (std::string_view word = text::next_word(line); !word.empty(); word = text::next_word(line)) {
    if (!fields.empty() && fields.back().size() == 10 && fields.back()[4] == '-' &&
        fields.back().data() + 11 == word.data() && word.find(':') != std::string_view::npos) {
      fields.back() = {fields.back().data(), 11 + word.size()};
    } else {
      fields.push_back(trim(word));
    }
  }
}

size_t find_column(const std::vector<std::string_view>& header, const std::string& column) {
  const auto found = std::ranges::find(header, column);
  if (found != header.end()) return static_cast<size_t>(found - header.begin());
  const auto number = text::parse_integer(column);
  return number && *number > 0 ? static_cast<size_t>(*number) - 1 : kNoColumn;
}

std::string line_place(const std::string& file, size_t line) {
  return file + ":" + std::to_string(line);
}

std::string base_name(std::string_view path) {
  const size_t slash = path.find_last_of("/\\");
  return std::string(slash == std::string_view::npos ? path : path.substr(slash + 1));
}

/// Compares names such that a_2 is before a_10.
bool is_before(const fs::path& left, const fs::path& right) {
  const std::string a = left.filename().string(), b = right.filename().string();
  size_t i = 0, j = 0;
  const auto is_digit = [](char c) { return kTenDigits.find(c) != std::string_view::npos; };
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const auto number = [](const std::string& text, size_t& at) {
        const size_t begin = std::min(text.find_first_not_of('0', at), text.size());
        at = std::min(text.find_first_not_of(kTenDigits, at), text.size());
        return text.substr(std::min(begin, at), at - std::min(begin, at));
      };
      const std::string left_number = number(a, i), right_number = number(b, j);
      if (left_number.size() != right_number.size())
        return left_number.size() < right_number.size();
      if (left_number != right_number) return left_number < right_number;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;
}

Result<std::vector<StampedFile>> stamp_by_rows(const std::vector<fs::path>& files,
                                               const StampRule& rule, const fs::path& base,
                                               std::vector<Error>& notes) {
  const std::string path = (base / rule.file).string();
  const auto text = text::read_text(path, kMaxStampBytes);
  if (!text) return tl::unexpected(text.error());
  const auto rows = parse_stamp_rows(*text, path, rule);
  if (!rows) return tl::unexpected(rows.error());
  std::vector<StampedFile> stamped;
  if (rule.files_column.empty()) {
    if (rows->size() != files.size()) {
      return fail("has " + std::to_string(rows->size()) + " stamps for " +
                      std::to_string(files.size()) + " files",
                  path, "name the column of their names: files_column");
    }
    size_t decreasing = 0;
    for (size_t k = 0; k < files.size(); ++k) {
      if (k > 0 && (*rows)[k].stamp <= (*rows)[k - 1].stamp && decreasing++ == 0)
        notes.push_back({"the stamp is not after the one before", line_place(path, (*rows)[k].line),
                         "files are taken in order of their stamps"});
      stamped.push_back({{.stamp = (*rows)[k].stamp}, files[k]});
    }
    return stamped;
  }
  std::map<std::string, Stamp> by_name;
  for (const StampRow& row : *rows) by_name[row.file] = row.stamp;
  for (const fs::path& file : files) {
    const auto found = by_name.find(file.filename().string());
    if (found != by_name.end()) stamped.push_back({{.stamp = found->second}, file});
  }
  if (stamped.empty() && !files.empty()) {
    return fail("names none of the files", path,
                "its first is '" + (rows->empty() ? "" : rows->front().file) + "', the folder's '" +
                    files.front().filename().string() + "'");
  }
  if (stamped.size() < files.size()) {
    notes.push_back(
        {std::to_string(files.size() - stamped.size()) + " files are not taken: they have no row",
         path, ""});
  }
  if (stamped.size() < by_name.size()) {
    notes.push_back(
        {std::to_string(by_name.size() - stamped.size()) + " rows are of files that are not there",
         path, ""});
  }
  return stamped;
}

}  // namespace

std::optional<std::string> StampRule::invalid() const {
  const int ways = (file.empty() ? 0 : 1) + (names ? 1 : 0) + (rate_hz ? 1 : 0);
  if (ways != 1) return "stamps: give one of file, names and rate_hz";
  if (!unit_digits().contains(unit)) return "stamps: unit must be \"s\", \"ms\", \"us\" or \"ns\"";
  if (rate_hz && !(*rate_hz >= 0.001 && *rate_hz <= 10'000))
    return "stamps: rate_hz must be between 0.001 and 10000";
  if (!rate_hz && start) return "stamps: start belongs to rate_hz";
  if (file.empty() && !(column.empty() && files_column.empty()))
    return "stamps: column and files_column belong to file";
  return std::nullopt;
}

Result<StampRule> read_stamp_rule(const toml::table& source, const std::string& file) {
  recording::TomlTable table(source, file, "stamps");
  StampRule rule;
  table.read("file", rule.file);
  read_column(table, "column", rule.column);
  read_column(table, "files_column", rule.files_column);
  table.read("names", rule.names);
  table.read("rate_hz", rule.rate_hz);
  read_start(table, rule.start);
  table.read("unit", rule.unit);
  double offset_s = 0;
  table.read("offset_s", offset_s);
  if (std::abs(offset_s) <= 1e9) {
    rule.offset = from_seconds(offset_s);
  } else {
    table.report_error("offset_s", "offset_s must be between -1e9 and 1e9");
  }
  if (auto wrong = table.finish()) return tl::unexpected(std::move(*wrong));
  if (const auto wrong = rule.invalid()) {
    const bool of_unit = !unit_digits().contains(rule.unit);
    table.report_error(of_unit ? "unit" : rule.rate_hz ? "rate_hz" : "file", *wrong);
    return tl::unexpected(*table.finish());
  }
  return rule;
}

std::optional<Stamp> parse_stamp_in(std::string_view text, const std::string& unit) {
  const auto digits = unit_digits().find(unit);
  if (digits == unit_digits().end() || text.size() > 60) return std::nullopt;
  std::string number;
  if (digits->second == 0) {  // also "2018-08-02T16:14:48Z"
    if (text.ends_with('Z')) text.remove_suffix(1);
    for (const char c : text) number += c == 'T' ? ' ' : c;
  } else {  // the point moves to the left
    const size_t point = std::min(text.find('.'), text.size());
    if (text.find_first_of(kTenDigits) == std::string_view::npos ||
        text.find_first_not_of("0123456789.") != std::string_view::npos)
      return std::nullopt;
    for (size_t k = point; k < digits->second + 1; ++k) number += '0';
    number += text.substr(0, point);
    const size_t cut = number.size() - digits->second;
    number = number.substr(0, cut) + "." + number.substr(cut);
    if (point < text.size()) number += text.substr(point + 1);
  }
  const auto stamp = text::parse_stamp(number);
  if (!stamp || *stamp < Stamp() || *stamp > kLatestStamp) return std::nullopt;
  return stamp;
}

std::optional<Stamp> parse_stamp_in_name(std::string_view stem, const std::string& unit) {
  const size_t last = stem.find_last_of(kTenDigits);
  if (last == std::string_view::npos) return std::nullopt;
  size_t begin = last + 1;
  bool has_point = false;
  while (begin > 0) {
    const char c = stem[begin - 1];
    if (c == '.' && !has_point) {
      has_point = true;
    } else if (kTenDigits.find(c) == std::string_view::npos) {
      break;
    }
    --begin;
  }
  std::string_view number = stem.substr(begin, last + 1 - begin);
  if (number.starts_with('.')) number.remove_prefix(1);
  return parse_stamp_in(number, unit);
}

Result<std::vector<StampRow>> parse_stamp_rows(std::string_view text, const std::string& file,
                                               const StampRule& rule) {
  std::vector<StampRow> rows;
  std::vector<std::string_view> fields;
  std::optional<char> separator;
  size_t stamp_column = 0, files_column = kNoColumn;
  for (size_t line_number = 1; !text.empty(); ++line_number) {
    const size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trim(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty() || line.starts_with('#')) continue;
    const bool is_first = !separator;
    if (is_first) separator = separator_of(line);
    split_fields(line, *separator, fields);
    if (is_first) {
      stamp_column = rule.column.empty() ? 0 : find_column(fields, rule.column);
      if (!rule.files_column.empty()) files_column = find_column(fields, rule.files_column);
      for (const auto& [name, column] :
           {std::pair(rule.column, stamp_column), std::pair(rule.files_column, files_column)}) {
        if (name.empty() || column < fields.size()) continue;
        std::string names;
        for (const auto field : fields) names += (names.empty() ? "" : ", ") + std::string(field);
        return fail("has no column '" + name + "'", line_place(file, line_number),
                    "columns: " + names.substr(0, 200));
      }
    }
    const auto stamp = stamp_column < fields.size()
                           ? parse_stamp_in(fields[stamp_column], rule.unit)
                           : std::nullopt;
    if (!stamp) {
      if (is_first) continue;  // the header
      return fail("has no stamp in " + rule.unit, line_place(file, line_number),
                  std::string("'").append(line.substr(0, 60)).append("'"));
    }
    StampRow row{*stamp, "", line_number};
    if (!rule.files_column.empty()) {
      if (files_column >= fields.size() || fields[files_column].empty())
        return fail("has no name of a file", line_place(file, line_number));
      row.file = base_name(fields[files_column]);
    }
    rows.push_back(std::move(row));
  }
  if (rows.empty()) return fail("has no stamps", file);
  return rows;
}

Result<std::vector<fs::path>> list_in_order(const fs::path& folder,
                                            const std::vector<std::string>& extensions) {
  std::error_code failed;
  std::vector<fs::path> files;
  fs::directory_iterator entries(folder, failed);
  if (failed) return fail("cannot be listed: " + failed.message(), folder.string());
  for (; entries != fs::directory_iterator(); entries.increment(failed)) {
    std::string extension = entries->path().extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    std::error_code ignored;
    if (std::ranges::find(extensions, extension) != extensions.end() &&
        entries->is_regular_file(ignored))
      files.push_back(entries->path());
    if (files.size() > kMaxListedFiles) return fail("has too many files", folder.string());
  }
  if (files.empty()) {
    std::string names;
    for (const std::string& extension : extensions)
      names += (names.empty() ? "" : ", ") + extension;
    return fail("has no files with the extensions " + names, folder.string());
  }
  std::ranges::sort(files, is_before);
  return files;
}

Result<std::vector<StampedFile>> stamp_files(const std::vector<fs::path>& files,
                                             const StampRule& rule, const fs::path& base,
                                             Stamp start, std::vector<Error>& notes) {
  std::vector<StampedFile> stamped;
  if (!rule.file.empty()) {
    auto by_rows = stamp_by_rows(files, rule, base, notes);
    if (!by_rows) return by_rows;
    stamped = std::move(*by_rows);
  } else {
    for (size_t k = 0; k < files.size(); ++k) {
      auto stamp = parse_stamp_in_name(files[k].stem().string(), rule.unit);
      if (rule.rate_hz)
        stamp = rule.start.value_or(start) + from_seconds(static_cast<double>(k) / *rule.rate_hz);
      if (!stamp) return fail("has no stamp in " + rule.unit + " in its name", files[k].string());
      stamped.push_back({{.stamp = *stamp}, files[k]});
    }
  }
  for (StampedFile& file : stamped) file.times.stamp += rule.offset;
  std::ranges::stable_sort(stamped, {}, [](const StampedFile& file) { return file.times.stamp; });
  return stamped;
}

}  // namespace infuse::importers
