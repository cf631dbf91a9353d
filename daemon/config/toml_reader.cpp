#include "daemon/config/toml_reader.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace infuse::daemon {

std::string place_in(const std::string& file, const toml::source_region& region) {
  return fmt::format("{}:{}:{}", file, region.begin.line, region.begin.column);
}

TomlReader::TomlReader(const toml::table& table, std::string file, std::string name)
    : table_(table), file_(std::move(file)), name_(std::move(name)) {}

const toml::node* TomlReader::find(std::string_view key) {
  known_.emplace_back(key);
  return table_.get(key);
}

std::string TomlReader::full(std::string_view key) const {
  return name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
}

void TomlReader::note(const toml::node& at, std::string what, std::string hint) {
  if (error_) return;
  error_ = Error{std::move(what), place_in(file_, at.source()), std::move(hint)};
}

void TomlReader::read(std::string_view key, std::string& value) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const auto text = node->value_exact<std::string>();
  if (!text)
    return note(*node, full(key) + " is not a string", fmt::format("e.g. {} = \"...\"", full(key)));
  value = *text;
}

void TomlReader::read(std::string_view key, double& value) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  if (!node->is_number()) return note(*node, full(key) + " is not a number", "");
  const double number = node->value<double>().value_or(std::nan(""));
  if (!std::isfinite(number)) return note(*node, full(key) + " is not finite", "");
  value = number;
}

void TomlReader::read_integer(std::string_view key, int64_t& value, int64_t min, int64_t max) {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const auto number = node->value_exact<int64_t>();
  if (!number) return note(*node, full(key) + " is not a whole number", "");
  if (*number < min || *number > max) {
    return note(*node, full(key) + " is out of range", fmt::format("{} ... {}", min, max));
  }
  value = *number;
}

void TomlReader::read_seconds(std::string_view key, Duration& value) {
  double seconds = to_seconds(value);
  read(key, seconds);
  value = from_seconds(seconds);
}

const toml::table* TomlReader::table(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) return nullptr;
  if (!node->is_table()) note(*node, full(key) + " is not a table", fmt::format("[{}]", full(key)));
  return node->as_table();
}

std::vector<const toml::table*> TomlReader::tables(std::string_view key) {
  std::vector<const toml::table*> list;
  const toml::node* node = find(key);
  if (node == nullptr) return list;
  const toml::array* array = node->as_array();
  if (array == nullptr)
    note(*node, full(key) + " is not a list of tables", fmt::format("[[{}]]", full(key)));
  for (size_t i = 0; array != nullptr && i < array->size(); ++i) {
    const toml::node& entry = (*array)[i];
    if (entry.is_table()) {
      list.push_back(entry.as_table());
    } else {
      note(entry, full(key) + " holds something that is not a table",
           fmt::format("[[{}]]", full(key)));
    }
  }
  return list;
}

void TomlReader::wrong(const std::string& what) {
  note(table_, name_.empty() ? what : name_ + ": " + what, "");
}

std::optional<Error> TomlReader::error() {
  for (const auto& [key, node] : table_) {
    if (std::find(known_.begin(), known_.end(), key.str()) != known_.end()) continue;
    std::string keys = "known keys:";
    for (const std::string& known : known_) keys += (&known == known_.data() ? " " : ", ") + known;
    note(node, fmt::format("unknown key '{}'", full(key.str())), keys);
  }
  return error_;
}

}  // namespace infuse::daemon
