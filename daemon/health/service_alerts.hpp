#pragma once

#include <array>

#include "daemon/health/alert.hpp"

namespace infuse::daemon {

// Alerts about the service itself, raised by what happens and not by a check at each tick. HEALTH
// does not list them.

inline constexpr AlertDescription kRestartedAlert{
    "restarted", Level::kWarn, Delays::kNone,
    "The previous run crashed, was stuck, or did not end by itself; not cleared. See `journalctl "
    "-u infused`, and CRASHES.",
    false};

inline constexpr AlertDescription kSavedCalibrationsAlert{
    "saved_calibrations", Level::kWarn, Delays::kNone,
    "The saved calibrations could not be read; the file is kept as *.unreadable; not cleared. "
    "Check `infuse calibration`.",
    false};

inline constexpr AlertDescription kRecordAlert{
    "record", Level::kWarn, Delays::kNone,
    "A recording ended prematurely, an alert is not recorded, or a recording is not in the spool; "
    "cleared when a recording begins. Free space on the disk.",
    false};

/// All of them.
inline constexpr std::array kServiceAlerts{kRestartedAlert, kSavedCalibrationsAlert, kRecordAlert};

}  // namespace infuse::daemon
