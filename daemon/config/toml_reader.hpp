#pragma once

#include <toml++/toml.h>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Reads the keys of one TOML table into options. The first thing that is wrong is kept and what
/// follows changes nothing, so that a caller reads every key in a row and asks once at the end.
class TomlReader {
 public:
  /// `name` is the table's, for messages: "health"; empty for the file itself. The table outlives
  /// the reader.
  TomlReader(const toml::table& table, std::string file, std::string name);

  // Each takes over the key's value where the key exists; it must be of the right type and range.

  void read(std::string_view key, std::string& value);
  void read(std::string_view key, double& value);
  /// An integer in min ... max.
  template <class Integer>
  void read(std::string_view key, Integer& value, Integer min, Integer max) {
    int64_t wide = static_cast<int64_t>(value);
    read_integer(key, wide, static_cast<int64_t>(min), static_cast<int64_t>(max));
    value = static_cast<Integer>(wide);
  }
  /// A number of seconds.
  void read_seconds(std::string_view key, Duration& value);

  /// The table of that name, or null; and the tables of an array of tables.
  const toml::table* table(std::string_view key);
  std::vector<const toml::table*> tables(std::string_view key);

  /// Notes that the whole table is wrong.
  void wrong(const std::string& what);

  /// The first error, unknown keys included.
  std::optional<Error> error();

 private:
  const toml::node* find(std::string_view key);
  void read_integer(std::string_view key, int64_t& value, int64_t min, int64_t max);
  void note(const toml::node& at, std::string what, std::string hint);
  std::string full(std::string_view key) const;

  const toml::table& table_;
  std::string file_;
  std::string name_;
  std::vector<std::string> known_;
  std::optional<Error> error_;
};

/// "file:line:column".
std::string place_in(const std::string& file, const toml::source_region& region);

}  // namespace infuse::daemon
