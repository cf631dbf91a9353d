#include "drivers/recording/toml_table.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/recording/rigid_matrix.hpp"

namespace infuse::recording {
namespace {

/// Maximum number of parts of a dotted key: far above any real one, far below the stack's size.
constexpr size_t kMaxKeyParts = 256;

/// The first line with a key of more than `kMaxKeyParts` parts; 0: there is none. A dotted key
/// makes a table for each part, and toml++ destroys nested tables by recursion: 100 000 of them
/// overflow the stack. Strings count like keys, so that none can hide one.
size_t find_deep_key(std::string_view text) {
  size_t line = 1;
  size_t dots = 0;
  bool comment = false;
  bool blank = true;  // so far, the line
  for (const char c : text) {
    if (c == '\n') {
      ++line;
      dots = 0;
      comment = false;
      blank = true;
      continue;
    }
    comment |= blank && c == '#';
    blank &= c == ' ' || c == '\t';
    if (std::string_view("=,{}[]").find(c) != std::string_view::npos) dots = 0;
    if (c == '.' && !comment && ++dots >= kMaxKeyParts) return line;
  }
  return 0;
}

}  // namespace

Result<toml::table> parse_toml(std::string_view text, const std::string& file) {
  if (text.size() > kMaxTomlBytes)
    return fail("is longer than " + std::to_string(kMaxTomlBytes) + " bytes", file);
  if (const size_t line = find_deep_key(text); line != 0) {
    return fail("a key has more than " + std::to_string(kMaxKeyParts) + " parts",
                file + ":" + std::to_string(line));
  }
  toml::parse_result parsed = toml::parse(text);
  if (!parsed) {
    std::string where = file;
    where.append(":").append(std::to_string(parsed.error().source().begin.line));
    return fail(std::string(parsed.error().description()), std::move(where));
  }
  return std::move(parsed).table();
}

const toml::node* TomlTable::node(std::string_view key) {
  if (std::find(known_keys_.begin(), known_keys_.end(), key) == known_keys_.end())
    known_keys_.emplace_back(key);
  return table_.get(key);
}

void TomlTable::read(std::string_view key, std::string& value) {
  const toml::node* found = node(key);
  if (found == nullptr) return;
  const auto* text = found->as_string();
  if (text == nullptr) return report_wrong_type(key, "a string in quotes");
  value = text->get();
}

void TomlTable::read(std::string_view key, bool& value) {
  const toml::node* found = node(key);
  if (found == nullptr) return;
  const auto* boolean = found->as_boolean();
  if (boolean == nullptr) return report_wrong_type(key, "true or false");
  value = boolean->get();
}

void TomlTable::read(std::string_view key, std::optional<bool>& value) {
  if (node(key) == nullptr) return;
  read(key, value.emplace());
}

void TomlTable::read(std::string_view key, double& value) {
  std::optional<double> number;
  read(key, number);
  if (number) value = *number;
}

void TomlTable::read(std::string_view key, std::optional<double>& value) {
  const toml::node* found = node(key);
  if (found == nullptr) return;
  if (!found->is_number()) return report_wrong_type(key, "a number");
  const auto number = found->value<double>();
  if (!number || !std::isfinite(*number)) return report_wrong_type(key, "a finite number");
  value = number;
}

void TomlTable::read(std::string_view key, int64_t min_value, int64_t max_value, int64_t& value) {
  const toml::node* found = node(key);
  if (found == nullptr) return;
  const auto* number = found->as_integer();
  if (number == nullptr || number->get() < min_value || number->get() > max_value) {
    return report_wrong_type(
        key, "an integer from " + std::to_string(min_value) + " to " + std::to_string(max_value));
  }
  value = number->get();
}

void TomlTable::read(std::string_view key, size_t max_count, std::vector<double>& values) {
  const toml::node* found = node(key);
  if (found == nullptr) return;
  const toml::array* array = found->as_array();
  const auto is_number = [](const toml::node& item) {
    return item.is_number() && std::isfinite(item.value<double>().value_or(0));
  };
  if (array == nullptr || array->size() > max_count ||
      !std::all_of(array->begin(), array->end(), is_number)) {
    return report_wrong_type(key, "a list of at most " + std::to_string(max_count) + " numbers");
  }
  values.clear();
  for (const toml::node& item : *array) values.push_back(item.value<double>().value_or(0));
}

void TomlTable::read(std::string_view key, size_t max_count, std::vector<std::string>& values) {
  const toml::node* found = node(key);
  if (found == nullptr) return;
  const toml::array* array = found->as_array();
  const auto is_string = [](const toml::node& item) { return item.is_string(); };
  if (array == nullptr || array->size() > max_count ||
      !std::all_of(array->begin(), array->end(), is_string)) {
    return report_wrong_type(key, "a list of at most " + std::to_string(max_count) + " strings");
  }
  values.clear();
  for (const toml::node& item : *array) values.push_back(item.as_string()->get());
}

void TomlTable::read(std::string_view key, Eigen::Isometry3d& T) {
  if (node(key) == nullptr) return;
  std::vector<double> numbers;
  read(key, 16, numbers);
  if (error_) return;
  if (numbers.size() != 16) {
    return report_error(key, std::string(key) + " must be 16 numbers by row",
                        std::to_string(numbers.size()) + " are given");
  }
  const auto rigid = to_rigid(numbers);
  if (!rigid) {
    return report_error(key, std::string(key) + " is not a rigid motion",
                        "a rotation, a translation in the fourth column, last row 0 0 0 1");
  }
  T = *rigid;
}

const toml::table* TomlTable::table(std::string_view key) {
  const toml::node* found = node(key);
  if (found == nullptr) return nullptr;
  if (!found->is_table()) report_wrong_type(key, "a table: [" + std::string(key) + "]");
  return found->as_table();
}

std::vector<const toml::table*> TomlTable::tables(std::string_view key, size_t max_count) {
  std::vector<const toml::table*> result;
  const toml::node* found = node(key);
  if (found == nullptr) return result;
  const toml::array* array = found->as_array();
  const auto is_table = [](const toml::node& item) { return item.is_table(); };
  if (array == nullptr || array->size() > max_count ||
      !std::all_of(array->begin(), array->end(), is_table)) {
    report_wrong_type(
        key, "at most " + std::to_string(max_count) + " tables: [[" + std::string(key) + "]]");
    return result;
  }
  for (const toml::node& item : *array) result.push_back(item.as_table());
  return result;
}

void TomlTable::require(std::string_view key) {
  if (node(key) == nullptr) report_table_error(name_ + " has no " + std::string(key));
}

void TomlTable::report_error(std::string_view key, const std::string& what, std::string hint) {
  const toml::node* found = node(key);
  set_error(found != nullptr ? found->source().begin : table_.source().begin, what,
            std::move(hint));
}

void TomlTable::report_table_error(const std::string& what, std::string hint) {
  set_error(table_.source().begin, what, std::move(hint));
}

void TomlTable::report_wrong_type(std::string_view key, const std::string& expected) {
  report_error(key, std::string(key) + " must be " + expected);
}

void TomlTable::set_error(toml::source_position at, const std::string& what, std::string hint) {
  if (error_) return;
  std::string where = file_;
  if (at) where.append(":").append(std::to_string(at.line));
  error_ = Error{what, std::move(where), std::move(hint)};
}

std::optional<Error> TomlTable::finish() {
  for (const auto& [key, value] : table_) {
    if (std::find(known_keys_.begin(), known_keys_.end(), key.str()) != known_keys_.end()) continue;
    std::string names;
    for (const std::string& name : known_keys_) names += (names.empty() ? "" : ", ") + name;
    set_error(key.source().begin, "unknown key '" + std::string(key.str()) + "'",
              "known keys: " + names);
  }
  return error_;
}

}  // namespace infuse::recording
