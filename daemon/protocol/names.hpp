#pragma once

#include <array>
#include <string_view>

#include "daemon/health/level.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/clock_state.hpp"

namespace infuse::daemon {

// Names of enumerators on the wire. `kRange<E>`: the first and the last one that occur there.

/// First and last enumerator on the wire.
template <class E>
inline constexpr std::array<E, 2> kRange{};

/// Kinds of devices.
inline constexpr std::array<std::string_view, 6> kDeviceKinds = {"lidar", "camera", "can",
                                                                 "speed", "imu",    "gnss"};
/// Kinds of devices that are not lidars.
inline constexpr std::array<std::string_view, 5> kStreamKinds = {"camera", "can", "speed", "imu",
                                                                 "gnss"};
/// Sources of the stamps of a live CAN bus.
inline constexpr std::array<std::string_view, 2> kStampSources = {"hardware", "kernel"};

/// States of an alert.
enum class AlertState : uint8_t { kRaised, kCleared };
/// States of a recording.
enum class RecordState : uint8_t { kRecording, kEnded, kFailed };

template <>
inline constexpr std::array<Level, 2> kRange<Level> = {Level::kOk, Level::kStale};
template <>
inline constexpr std::array<AlertState, 2> kRange<AlertState> = {AlertState::kRaised,
                                                                 AlertState::kCleared};
template <>
inline constexpr std::array<RecordState, 2> kRange<RecordState> = {RecordState::kRecording,
                                                                   RecordState::kFailed};
template <>
inline constexpr std::array<PoseFrame, 2> kRange<PoseFrame> = {PoseFrame::kOdom, PoseFrame::kMap};
template <>
inline constexpr std::array<ClockState::Source, 2> kRange<ClockState::Source> = {
    ClockState::Source::kNone, ClockState::Source::kPtp};
template <>
inline constexpr std::array<streetmap::TrackState, 2> kRange<streetmap::TrackState> = {
    streetmap::TrackState::kUnsure, streetmap::TrackState::kLost};
template <>
inline constexpr std::array<places::LocaliserState, 2> kRange<places::LocaliserState> = {
    places::LocaliserState::kLost, places::LocaliserState::kTracking};
template <>
inline constexpr std::array<monitoring::CalibrationState, 2> kRange<monitoring::CalibrationState> =
    {monitoring::CalibrationState::kOk, monitoring::CalibrationState::kUnusable};
template <>
inline constexpr std::array<CalibrationOrigin, 2> kRange<CalibrationOrigin> = {
    CalibrationOrigin::kConfigured, CalibrationOrigin::kGiven};
template <>
inline constexpr std::array<CalibrationUse, 2> kRange<CalibrationUse> = {CalibrationUse::kEarlier,
                                                                         CalibrationUse::kProposed};
template <>
inline constexpr std::array<monitoring::UpdatePolicy, 2> kRange<monitoring::UpdatePolicy> = {
    monitoring::UpdatePolicy::kAlertOnly, monitoring::UpdatePolicy::kApplyWithin};
template <>
inline constexpr std::array<monitoring::CameraFault, 2> kRange<monitoring::CameraFault> = {
    monitoring::CameraFault::kBlack, monitoring::CameraFault::kSwapped};

/// Returns "raised" or "cleared".
constexpr const char* name_of(AlertState state) {
  return state == AlertState::kRaised ? "raised" : "cleared";
}
/// Returns "recording", "ended" or "failed".
constexpr const char* name_of(RecordState state) {
  return std::array{"recording", "ended", "failed"}[static_cast<size_t>(state)];
}
/// Returns "configured", "estimated" or "given".
constexpr const char* name_of(CalibrationOrigin origin) {
  return std::array{"configured", "estimated", "given"}[static_cast<size_t>(origin)];
}
/// Returns "earlier", "in use", "previous" or "proposed".
constexpr const char* name_of(CalibrationUse use) {
  return std::array{"earlier", "in use", "previous", "proposed"}[static_cast<size_t>(use)];
}
/// Returns "odom" or "map".
constexpr const char* name_of(PoseFrame frame) {
  return frame == PoseFrame::kOdom ? "odom" : "map";
}
/// Returns "none", "host", "power_up", "top_of_hour", "utc" or "ptp".
constexpr const char* name_of(ClockState::Source source) {
  return std::array{
      "none", "host", "power_up", "top_of_hour", "utc", "ptp"}[static_cast<size_t>(source)];
}
/// Returns "alert-only", "apply" or "apply-within".
constexpr const char* name_of(monitoring::UpdatePolicy policy) {
  return std::array{"alert-only", "apply", "apply-within"}[static_cast<size_t>(policy)];
}

}  // namespace infuse::daemon
