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

/// Parses TOML text of at most 1 MiB; errors carry file and line.
Result<toml::table> parse_toml(std::string_view text, const std::string& file);

/// Reads a TOML table key by key and keeps the first thing that was wrong, with its line. Every key
/// that is requested becomes a known one; `finish` complains about the others.
class TomlTable {
 public:
  /// `name` is for messages: "lidar".
  TomlTable(const toml::table& table, std::string file, std::string name)
      : table_(table), file_(std::move(file)), name_(std::move(name)) {}

  /// Each leaves `value` as it is where the key is absent.
  void read(std::string_view key, std::string& value);
  void read(std::string_view key, bool& value);
  void read(std::string_view key, double& value);
  void read(std::string_view key, std::optional<double>& value);
  /// An integer from `lowest` to `highest`.
  void read(std::string_view key, int64_t lowest, int64_t highest, int64_t& value);
  /// At most `most` numbers.
  void read(std::string_view key, size_t most, std::vector<double>& values);
  /// 16 numbers by row that are a rigid motion.
  void read(std::string_view key, Eigen::Isometry3d& T);

  /// Sub-tables: one (null where absent), or an array of them (at most `most`).
  const toml::table* table(std::string_view key);
  std::vector<const toml::table*> tables(std::string_view key, size_t most);

  /// The value itself; null where absent.
  const toml::node* node(std::string_view key);

  /// Complains where the key is absent.
  void require(std::string_view key);

  /// Complains at a value of this table, or at the table itself where the key is absent.
  void report_error(std::string_view key, const std::string& what, std::string hint = {});
  /// Complains at the table itself.
  void report_table_error(const std::string& what, std::string hint = {});

  /// Complains about unknown keys; gives what was wrong first, if anything.
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
