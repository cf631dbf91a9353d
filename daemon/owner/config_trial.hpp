#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// A configuration that is tried: until it is confirmed, the one before it comes back. What is on
/// the disk says all of it, so that a kill or a power cut at any moment leaves one of the two:
///
///     infused.toml.previous    the one before
///     infused.toml.trying      a process that waits for the new one; gone when it is confirmed
class ConfigTrial {
 public:
  explicit ConfigTrial(std::filesystem::path file);

  /// Keeps the configuration that is there and puts another in its place.
  Result<void> begin(std::string_view text) const;

  /// Keeps the new one.
  Result<void> confirm() const;

  /// Puts the one before back.
  Result<void> restore() const;

  /// Takes a trial back whose process is gone. Returns true if there was one.
  Result<bool> settle() const;

 private:
  std::filesystem::path file_, previous_, trying_;
};

}  // namespace infuse::daemon
