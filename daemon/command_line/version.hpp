#pragma once

namespace infuse::daemon {

/// The version of all programs, with date and hash of the commit: "0.2.0~git20261127.566adb79".
const char* version();

}  // namespace infuse::daemon
