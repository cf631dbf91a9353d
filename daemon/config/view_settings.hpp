#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace infuse::daemon {

/// Live view in a browser: the `[view]` table of the configuration.
struct ViewSettings {
  uint16_t port = 0;                         ///< 0: none
  std::string bind = "127.0.0.1";            ///< address of an interface of this host
  std::string token;                         ///< secret in the page's address; empty: none
  std::vector<std::string> allowed_origins;  ///< pages of others, "http://host:port"
  size_t max_clients = 4;                    ///< number of pages that are open

  std::string path;  ///< Unix stream socket; empty: none

  bool enabled() const { return port != 0 || !path.empty(); }

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

}  // namespace infuse::daemon
