#include "daemon/tools/fleet/drive_entry.hpp"

#include <spdlog/fmt/fmt.h>

#include <set>

#include "daemon/tools/fleet/json_fields.hpp"
#include "drivers/text/text_file.hpp"
#include "fusion/calibration/pool_calibrations.hpp"
#include "fusion/geometry/symmetric_eigen.hpp"

namespace infuse::daemon {
namespace {

constexpr int kEntryForm = 1;  // version of entries
constexpr size_t kMaxStepBytes = size_t{16} << 20;
constexpr size_t kMaxSteps = 100;
constexpr size_t kMaxFailureText = 400;  // bytes
constexpr int64_t kDayNs = 86'400'000'000'000;

/// What a step left.
struct StepOutput {
  std::string name;
  int code = 0;
  Json json;
  std::string log;
};

std::string read_step_file(const std::filesystem::path& path) {
  return text::read_text(path, kMaxStepBytes).value_or("");
}

/// Days of a date of the Gregorian calendar since 1970-01-01; nothing if there is no such day.
std::optional<int64_t> days_of(const std::string& date) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (date.size() != 10) return std::nullopt;
  for (size_t i = 0; i < date.size(); ++i) {
    if ((i == 4 || i == 7) ? date[i] != '-' : !is_digit(date[i])) return std::nullopt;
  }
  const int year = std::stoi(date.substr(0, 4));
  const auto month = static_cast<unsigned>(std::stoi(date.substr(5, 2)));
  const auto day = static_cast<unsigned>(std::stoi(date.substr(8, 2)));
  const std::chrono::year_month_day calendar{std::chrono::year(year), std::chrono::month(month),
                                             std::chrono::day(day)};
  if (!calendar.ok() || year < 1970 || year > 2200) return std::nullopt;
  return std::chrono::sys_days(calendar).time_since_epoch().count();
}

/// The last message of a program of infuse in its log ("infuse calibrate: …"), without the
/// program's name. Other lines may hold times, which differ between runs.
std::string last_message(const std::string& log) {
  std::string last;
  for (size_t begin = 0; begin < log.size();) {
    const size_t end = std::min(log.find('\n', begin), log.size());
    const std::string_view line(log.data() + begin, end - begin);
    if (line.starts_with("infuse ") || line.starts_with("infused:")) {
      if (const size_t colon = line.find(": "); colon != line.npos) last = line.substr(colon + 2);
    }
    begin = end + 1;
  }
  return last.substr(0, kMaxFailureText);
}

/// Why a step failed; empty if it did not. Exit code 1 is the answer "no", which the output tells.
std::string failure_of(const StepOutput& step) {
  if ((step.code == 0 || step.code == 1) && step.json.is_object()) return {};
  const std::string message = last_message(step.log);
  std::string what = step.code == 124  ? "took longer than allowed"
                     : step.code > 128 ? fmt::format("ended by signal {}", step.code - 128)
                     : step.code <= 1  ? "printed no result"
                     : message.empty() ? fmt::format("ended with exit code {}", step.code)
                                       : message;
  if (what != message && !message.empty()) what += ": " + message;
  return what;
}

/// The stamps of a calibration's scenes: the earliest.
std::optional<int64_t> first_stamp(const Json& calibration) {
  std::optional<int64_t> first;
  const Json& scenes = field_of(calibration, "scenes");
  for (size_t i = 0; scenes.is_array() && i < scenes.size(); ++i) {
    const auto stamp = integer_field(scenes[i], "stamp");
    if (stamp && (!first || *stamp < *first)) first = stamp;
  }
  return first;
}

void copy_fields(const Json& from, std::initializer_list<const char*> keys, Json& to) {
  for (const char* key : keys) {
    if (const Json& value = field_of(from, key); !value.is_null()) to[key] = value;
  }
}

/// A calibration as an entry holds it.
Json calibration_entry(const Json& result) {
  Json entry = Json::object();
  copy_fields(
      result,
      {"camera", "lidar", "usable", "reason", "T_camera_lidar", "covariance",
       "covariance_of_scenes", "covariance_of_motion", "points", "support", "effective_scenes"},
      entry);
  const Json& scenes = field_of(result, "scenes");
  entry["scenes"] = scenes.is_array() ? scenes.size() : 0;
  return entry;
}

/// A replay's summary as an entry holds it: no durations of the host.
Json replay_entry(const Json& summary) {
  Json entry = Json::object();
  copy_fields(summary,
              {"drive_s", "sweeps", "returns", "packets", "packets_lost", "alerts", "notes"},
              entry);
  entry["levels"] = Json::object();
  for (const char* list : {"devices", "streams"}) {
    const Json& devices = field_of(summary, list);
    for (size_t i = 0; devices.is_array() && i < devices.size(); ++i) {
      entry["levels"][text_field(devices[i], "device")] = text_field(devices[i], "level");
    }
  }
  return entry;
}

void add_step(const StepOutput& step, Json& entry) {
  if (const std::string what = failure_of(step); !what.empty()) {
    entry["failures"].push_back({{"step", step.name}, {"what", what}});
  } else if (step.name.starts_with("calibrate")) {
    entry["calibrations"].push_back(calibration_entry(step.json));
  } else if (step.name == "replay") {
    entry["replay"] = replay_entry(step.json);
  } else if (step.name == "map") {
    entry["map"] = step.json;
  } else {
    entry["failures"].push_back({{"step", step.name}, {"what", "is no step that is known"}});
  }
}

/// Names of the steps in a folder, sorted.
Result<std::set<std::string>> step_names(const std::filesystem::path& folder) {
  std::set<std::string> names;
  std::error_code failed;
  for (std::filesystem::directory_iterator at(folder, failed), end; !failed && at != end;
       at.increment(failed)) {
    if (at->path().extension() == ".code") names.insert(at->path().stem().string());
  }
  if (failed) return fail("cannot be read: " + failed.message(), folder.string());
  if (names.empty() || names.size() > kMaxSteps) {
    return fail("holds no steps", folder.string(), "each has NAME.code, NAME.json and NAME.log");
  }
  return names;
}

/// The reason why a calibration's matrices cannot be used; sets them.
std::string read_matrices(const Json& json, EntryCalibration& calibration) {
  const auto T = motion_field(json, "T_camera_lidar");
  const auto all = matrix_field(json, "covariance"),
             scenes = matrix_field(json, "covariance_of_scenes"),
             motion = matrix_field(json, "covariance_of_motion");
  if (!T || !all || !scenes || !motion) return "its matrices cannot be read";
  calibration.T_camera_lidar = *T;
  calibration.covariance = *scenes + *motion;
  calibration.shared_covariance = *all - calibration.covariance;
  if (!calibration::is_covariance(calibration.covariance) || !calibration::is_covariance(*all)) {
    return "its covariance is not one";
  }
  // What is left by rounding of a part that is zero.
  const auto parts = geometry::symmetric_eigen<6>(calibration.shared_covariance);
  calibration.shared_covariance =
      parts.vectors * parts.values.cwiseMax(0).asDiagonal() * parts.vectors.transpose();
  return {};
}

EntryCalibration read_calibration(const Json& json) {
  EntryCalibration calibration{.camera = text_field(json, "camera"),
                               .lidar = text_field(json, "lidar")};
  if (field_of(json, "usable") != Json(true)) {
    calibration.reason = text_field(json, "reason");
    if (calibration.reason.empty()) calibration.reason = "not usable";
  } else {
    calibration.reason = read_matrices(json, calibration);
  }
  return calibration;
}

}  // namespace

std::optional<std::string> DriveName::invalid() const {
  if (vehicle.empty()) return "the vehicle's name is empty";
  if (drive.empty()) return "the drive's name is empty";
  if (!date.empty() && !days_of(date)) return "'" + date + "' is not a date such as 2026-03-01";
  return std::nullopt;
}

Result<Json> make_drive_entry(const std::filesystem::path& folder, const DriveName& name) {
  if (const auto wrong = name.invalid()) return fail(*wrong, folder.string());
  const auto names = step_names(folder);
  if (!names) return tl::unexpected(names.error());
  Json entry = {{"form", kEntryForm},
                {"vehicle", name.vehicle},
                {"drive", name.drive},
                {"failures", Json::array()},
                {"calibrations", Json::array()}};
  std::optional<int64_t> stamp;
  for (const std::string& step : *names) {
    StepOutput output{.name = step};
    const std::string code = read_step_file(folder / (step + ".code"));
    output.code = std::atoi(code.c_str());
    output.json = Json::parse(read_step_file(folder / (step + ".json")), nullptr, false);
    output.log = read_step_file(folder / (step + ".log"));
    const auto first = first_stamp(output.json);
    if (first && (!stamp || *first < *stamp)) stamp = first;
    add_step(output, entry);
  }
  if (const auto days = days_of(name.date)) stamp = *days * kDayNs;
  if (stamp) entry["stamp"] = *stamp;
  return entry;
}

Result<DriveEntry> parse_drive_entry(std::string_view text, const std::string& file) {
  const Json json = Json::parse(text, nullptr, false);
  if (field_of(json, "form") != Json(kEntryForm)) {
    return fail("is not an entry of a drive, or is of another release", file,
                "infuse fleet drive --help");
  }
  DriveEntry entry{.vehicle = text_field(json, "vehicle"), .drive = text_field(json, "drive")};
  if (entry.vehicle.empty() || entry.drive.empty()) return fail("names no vehicle or drive", file);
  if (const auto stamp = integer_field(json, "stamp")) entry.stamp = Stamp::from_ns(*stamp);
  const Json& calibrations = field_of(json, "calibrations");
  for (size_t i = 0; calibrations.is_array() && i < std::min(calibrations.size(), kMaxSteps); ++i) {
    EntryCalibration calibration = read_calibration(calibrations[i]);
    if (calibration.usable() && !entry.stamp) calibration.reason = "its date is not known";
    entry.calibrations.push_back(std::move(calibration));
  }
  const Json& failures = field_of(json, "failures");
  for (size_t i = 0; failures.is_array() && i < std::min(failures.size(), kMaxSteps); ++i) {
    entry.failures.push_back({text_field(failures[i], "step"), text_field(failures[i], "what")});
  }
  const Json& replay = field_of(json, "replay");
  entry.driven_s = number_field(replay, "drive_s");
  entry.alerts = integer_field(replay, "alerts");
  return entry;
}

Result<DriveEntry> read_drive_entry(const std::filesystem::path& path) {
  const auto text = text::read_text(path, kMaxStepBytes);
  if (!text) return tl::unexpected(text.error());
  return parse_drive_entry(*text, path.string());
}

}  // namespace infuse::daemon
