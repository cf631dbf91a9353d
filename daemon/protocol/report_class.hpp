#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace infuse::daemon {

/// Classes of reports that a client can watch.
enum class ReportClass : uint8_t {
  kDevices,
  kSweep,
  kFrame,
  kPose,
  kCalibration,
  kHealth,
  kAlert,
  kRecord
};

/// Watchable classes and their names on the wire.
inline constexpr std::array<std::pair<ReportClass, const char*>, 8> kReportClasses = {
    {{ReportClass::kDevices, "DEVICES"},
     {ReportClass::kSweep, "SWEEP"},
     {ReportClass::kFrame, "FRAME"},
     {ReportClass::kPose, "POSE"},
     {ReportClass::kCalibration, "CALIBRATION"},
     {ReportClass::kHealth, "HEALTH"},
     {ReportClass::kAlert, "ALERT"},
     {ReportClass::kRecord, "RECORD"}}};

/// Returns the class of that name (upper case), or nothing.
constexpr std::optional<ReportClass> report_class(std::string_view name) {
  for (const auto& [value, its_name] : kReportClasses) {
    if (name == its_name) return value;
  }
  return std::nullopt;
}

/// Returns the name of a class on the wire.
constexpr const char* name_of(ReportClass report_class) {
  return kReportClasses[static_cast<size_t>(report_class)].second;
}

/// A set of classes.
class ReportClasses {
 public:
  static constexpr ReportClasses all() {
    ReportClasses classes;
    for (const auto& entry : kReportClasses) classes.add(entry.first);
    return classes;
  }
  constexpr void add(ReportClass value) { bits_ |= bit(value); }
  constexpr bool has(ReportClass value) const { return (bits_ & bit(value)) != 0; }
  constexpr bool operator==(const ReportClasses&) const = default;

 private:
  static constexpr uint32_t bit(ReportClass value) { return 1U << static_cast<uint32_t>(value); }
  uint32_t bits_ = 0;
};

}  // namespace infuse::daemon
