#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "daemon/protocol/report_class.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// What a client asks.
struct Request {
  enum class Op : uint8_t {
    kWatch,
    kPoll,
    kDevices,
    // What changes the daemon; the owner's alone:
    kRecalibrate,  ///< estimate the camera's place anew now
    kApply,        ///< take what was estimated last
    kRollback,     ///< go back to what was in use before
    kFreeze,       ///< change nothing by itself any more; `on` false: do so again
    kRecord,       ///< record what the sensors say; `on` false: end that
  };
  Op op = Op::kPoll;
  ReportClasses classes;     ///< of kWatch
  std::string device;        ///< of what changes the daemon: the camera; empty: all
  bool on = true;            ///< of kFreeze and kRecord
  std::string name;          ///< of kRecord: the drive's; empty: the time
  Duration max_duration{0};  ///< of kRecord; 0: as configured
  uint64_t max_bytes = 0;    ///< of kRecord: bytes; 0: as configured

  /// The request changes the daemon.
  bool is_control() const { return op >= Op::kRecalibrate; }
};

/// The longest request line that is looked at, bytes.
inline constexpr size_t kMaxRequestBytes = 4096;

/// The deepest nesting of a request.
inline constexpr int kMaxRequestDepth = 8;

/// Reads one line, without its line feed. Any bytes are safe; `Error::where` is the op where it
/// could be read.
Result<Request> parse_request(std::string_view line);

/// The name of an op on the wire.
const char* name_of(Request::Op op);

}  // namespace infuse::daemon
