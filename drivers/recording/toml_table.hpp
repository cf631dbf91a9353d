#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/recording/toml_library.hpp"

namespace infuse::recording {

/// Maximum size of a TOML file.
inline constexpr size_t kMaxTomlBytes = 1 << 20;

/// Parses TOML text of at most `kMaxTomlBytes`. Errors contain file and line.
Result<toml::table> parse_toml(std::string_view text, const std::string& file);

/// Reads a TOML table key by key and keeps the first error, with its line. Every requested key
/// becomes a known key; `finish` reports unknown ones.
class TomlTable {
 public:
  /// `name` is used in messages, for example "lidar".
  TomlTable(const toml::table& table, std::string file, std::string name)
      : table_(table), file_(std::move(file)), name_(std::move(name)) {}

  /// Reads a value; leaves it unchanged if the key is absent.
  void read(std::string_view key, std::string& value);
  void read(std::string_view key, bool& value);
  void read(std::string_view key, std::optional<bool>& value);
  void read(std::string_view key, double& value);
  void read(std::string_view key, std::optional<double>& value);
  /// Reads an integer from `min_value` to `max_value`.
  void read(std::string_view key, int64_t min_value, int64_t max_value, int64_t& value);
  /// Reads a list of at most `max_count` numbers.
  void read(std::string_view key, size_t max_count, std::vector<double>& values);
  void read(std::string_view key, size_t max_count, std::vector<std::string>& values);
  /// Reads a rigid motion: 16 numbers by row.
  void read(std::string_view key, Eigen::Isometry3d& T);

  /// Returns a sub-table, or null if absent.
  const toml::table* table(std::string_view key);
  /// Returns an array of at most `max_count` sub-tables.
  std::vector<const toml::table*> tables(std::string_view key, size_t max_count);

  /// Returns a value of any type, or null if absent.
  const toml::node* node(std::string_view key);

  /// Reports an error if the key is absent.
  void require(std::string_view key);

  /// Reports an error at the line of a key, or of the table if the key is absent.
  void report_error(std::string_view key, const std::string& what, std::string hint = {});
  /// Reports an error at the line of the table.
  void report_table_error(const std::string& what, std::string hint = {});

  /// Checks for unknown keys. Returns the first error, if any.
  std::optional<Error> finish();

 private:
  void set_error(toml::source_position at, const std::string& what, std::string hint);
  void report_wrong_type(std::string_view key, const std::string& expected);

  const toml::table& table_;
  std::string file_;
  std::string name_;
  std::vector<std::string> known_keys_;
  std::optional<Error> error_;
};

}  // namespace infuse::recording
