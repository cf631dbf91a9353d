#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "daemon/protocol/reports.hpp"

namespace infuse::daemon {

/// Major and minor: a client of the same major can read everything that this one says.
inline constexpr std::array<int, 2> kProtocolVersion = {1, 0};

// Each of these gives one line of JSON without its line feed. The schemas of the same name say what
// stands in it.

/// The greeting. `session` differs from one start of the daemon to the next.
std::string version_message(std::string_view release, std::string_view session);

std::string devices_message(Stamp stamp, std::span<const Device> devices);

std::string sweep_message(const SweepReport& report, std::span<const Device> devices);

/// `cameras` are the devices of the cameras.
std::string frame_message(const FrameReport& report, std::span<const Device> cameras);

std::string pose_message(const PoseReport& report);

std::string calibration_message(const CalibrationReport& report);

/// `host` null: without what depends on this machine's speed.
std::string health_message(const HealthReport& report, std::span<const Device> devices,
                           const HostStats* host);

std::string alert_message(const AlertReport& report);

std::string record_message(const RecordReport& report);

/// `reports` were not sent since the client did not read.
std::string lost_message(Stamp stamp, uint64_t reports);

/// The request was carried out.
std::string ack_message(std::string_view op);

/// The request, or the connection, was refused. `op` empty where it is not known.
std::string error_message(std::string_view op, std::string_view what, std::string_view hint);

}  // namespace infuse::daemon
