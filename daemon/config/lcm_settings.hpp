#pragma once

#include <optional>
#include <string>

#include "drivers/lcm/lcm_sender.hpp"

namespace infuse::daemon {

/// Messages on LCM channels: the `[lcm]` table of the configuration.
struct LcmSettings {
  bool enabled = false;  ///< the table is there
  lcm::SenderOptions to;
  std::string prefix = "INFUSE";    ///< beginning of the channels' names
  std::string sweeps = "deskewed";  ///< which sweeps: "deskewed", "measured" or "none"
  size_t max_points = 8000;         ///< of a sweep; of more, every n-th is sent

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const {
    constexpr size_t kMaxPrefix = 16;
    if (auto wrong = to.invalid()) return wrong;
    if (prefix.empty() || prefix.size() > kMaxPrefix) return "prefix must have 1 to 16 bytes";
    if (sweeps != "deskewed" && sweeps != "measured" && sweeps != "none")
      return "sweeps must be deskewed, measured or none";
    if (max_points == 0) return "max_points must be positive";
    return std::nullopt;
  }
};

/// What is valid and yet may not work: the unit denies multicast groups. Nothing if it is off.
inline std::optional<Error> find_lcm_doubt(const LcmSettings& settings) {
  if (!settings.enabled) return std::nullopt;
  return Error{"infused.service permits private IPv4 addresses only: it may not send to " +
                   settings.to.group,
               "[lcm]", "install the drop-in lcm.conf, see infused(8)"};
}

}  // namespace infuse::daemon
