#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "daemon/config/config.hpp"
#include "drivers/recording/toml_table.hpp"

namespace infuse::daemon {

/// Reads the tables [[lidar]], [[camera]], [[can]] and [gnss] into a configuration that may have
/// sensors already: one of the same name is changed, others are added. Returns what is wrong, or
/// nothing.
std::optional<Error> read_sensors(recording::TomlTable& root, const std::string& file,
                                  Config& config);

/// Reads a non-negative integer within the range of `Integer`.
template <class Integer>
void read_integer(recording::TomlTable& table, std::string_view key, Integer& value) {
  int64_t wide = static_cast<int64_t>(value);
  constexpr auto kMaxValue = std::numeric_limits<Integer>::max();
  table.read(key, 0,
             std::cmp_less(kMaxValue, INT64_MAX) ? static_cast<int64_t>(kMaxValue) : INT64_MAX,
             wide);
  value = static_cast<Integer>(wide);
}

}  // namespace infuse::daemon
