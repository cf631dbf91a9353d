#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/protocol/report_class.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// A request of a client.
struct Request {
  enum class Op : uint8_t {
    kWatch,
    kPoll,
    kDevices,
    // Control requests, permitted to the owner only:
    kRecalibrate,  ///< re-estimate the calibration now
    kApply,        ///< use the proposed calibration, or the one with a number, or a given one
    kRollback,     ///< use the previous calibration
    kFreeze,       ///< disable automatic changes; `on` false: enable them
    kRecord,       ///< start a recording; `on` false: end it
  };
  Op op = Op::kPoll;
  ReportClasses classes;                            ///< of kWatch
  std::string device;                               ///< of calibrations: the camera; empty: all
  bool on = true;                                   ///< of kFreeze and kRecord
  std::optional<uint64_t> number;                   ///< of kApply: of a calibration
  std::optional<Eigen::Isometry3d> T_camera_lidar;  ///< of kApply: to be used
  std::string name;          ///< of kRecord: name of the drive; empty: the time
  Duration max_duration{0};  ///< of kRecord; 0: as configured
  uint64_t max_bytes = 0;    ///< of kRecord: bytes; 0: as configured

  /// True if the request changes the daemon.
  bool is_control() const { return op >= Op::kRecalibrate; }
};

/// Maximum length of a request line, bytes.
inline constexpr size_t kMaxRequestBytes = 4096;

/// Maximum nesting of a request.
inline constexpr int kMaxRequestDepth = 8;

/// Parses one line, without its line feed. Accepts any bytes; `Error::where` is the op, if known.
Result<Request> parse_request(std::string_view line);

/// Returns the name of an op on the wire.
const char* name_of(Request::Op op);

}  // namespace infuse::daemon
