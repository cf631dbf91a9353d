#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/owner/calibration_reports.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/report_text.hpp"
#include "daemon/protocol/number_json.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "drivers/recording/rigid_matrix.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kCalibrationsProgram = "infuse calibrations";

struct CalibrationsArguments {
  std::string socket, camera, rig, output;
  uint64_t number = 0;  // 0: those in use
  bool json = false;
};

std::optional<Eigen::Isometry3d> pose_of(const Json& calibration) {
  const auto numbers = numbers_of(calibration.value("T_camera_lidar", Json::array()), 16);
  return numbers ? recording::to_rigid(*numbers) : std::nullopt;
}

/// "0.52°, 1.3 cm from the one in use".
std::string distance_text(const Eigen::Isometry3d& T, const Eigen::Isometry3d& T_in_use) {
  const Eigen::Isometry3d between = T * T_in_use.inverse();
  return fmt::format("{:.2f}°, {:.1f} cm from the one in use",
                     Eigen::AngleAxisd(between.linear()).angle() / kDegree,
                     100 * (T.translation() - T_in_use.translation()).norm());
}

std::string line_of(const Json& calibration, const std::optional<Eigen::Isometry3d>& T_in_use) {
  const std::string use = text_of(calibration, "use");
  std::string line =
      fmt::format("  {:>4} {} {}", calibration.value("number", uint64_t{0}),
                  calibration.value("stamp", int64_t{0}) == 0 ? std::string("at first            ")
                                                              : utc_text(calibration, "stamp"),
                  text_of(calibration, "origin"));
  if (calibration.contains("estimated_from")) {
    line += fmt::format(" from {}", calibration["estimated_from"].get<uint64_t>());
  }
  if (use != "earlier") line += ", " + use;
  const auto T = pose_of(calibration);
  if (T && T_in_use && use != "in use") line += ", " + distance_text(*T, *T_in_use);
  return line + "\n";
}

std::string text_of_camera(const Json& report) {
  std::string text = text_of(report, "device") + "\n";
  const auto T_in_use = pose_of(report);
  for (const Json& calibration : report.value("calibrations", Json::array())) {
    text += line_of(calibration, T_in_use);
  }
  return text;
}

/// The calibration in use of a camera, or the one with the number; nothing: another camera has it.
std::optional<Eigen::Isometry3d> chosen_pose(const Json& report, uint64_t number) {
  if (number == 0) return pose_of(report);
  for (const Json& calibration : report.value("calibrations", Json::array())) {
    if (calibration.value("number", uint64_t{0}) == number) return pose_of(calibration);
  }
  return std::nullopt;
}

/// Writes a rig.toml with the daemon's calibrations in the place of its own.
int write_rig(const CalibrationsArguments& arguments, const std::vector<Json>& reports) {
  auto rig = recording::read_rig(arguments.rig);
  if (!rig) return print_error(kCalibrationsProgram, rig.error(), kUnreadable);
  size_t replaced = 0;
  for (const Json& report : reports) {
    const auto T = chosen_pose(report, arguments.number);
    for (CameraMount& camera : rig->cameras) {
      if (!T || camera.name != text_of(report, "device")) continue;
      camera.T_camera_lidar = *T;
      ++replaced;
    }
  }
  if (replaced == 0) {
    return print_error(kCalibrationsProgram,
                       {"no calibration of a camera in it", arguments.rig, ""}, kFailure);
  }
  const auto written = recording::write_rig(arguments.output, *rig);
  return written ? kDone : print_error(kCalibrationsProgram, written.error(), kFailure);
}

int run(const CalibrationsArguments& arguments) {
  const auto reports = poll_calibrations(arguments.socket, arguments.camera);
  if (!reports) return print_error(kCalibrationsProgram, reports.error(), kFailure);
  if (!arguments.output.empty()) return write_rig(arguments, *reports);
  Json cameras = Json::array();
  for (const Json& report : *reports) {
    cameras.push_back({{"camera", text_of(report, "device")},
                       {"calibrations", report.value("calibrations", Json::array())}});
    if (!arguments.json) std::cout << text_of_camera(report);
  }
  if (arguments.json) std::cout << json_text({{"cameras", cameras}}) << "\n";
  return kDone;
}

}  // namespace

Command declare_calibrations(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand(
      "calibrations",
      "list the calibrations that were in use or proposed, or write them into a rig.toml");
  const auto arguments = std::make_shared<CalibrationsArguments>();
  app->add_option("--camera", arguments->camera, "camera (default: all)")->type_name("NAME");
  app->add_option("--socket", arguments->socket, "socket of the daemon")->type_name("PATH");
  CLI::Option* rig = app->add_option("--rig", arguments->rig, "rig.toml with the other sensors")
                         ->type_name("FILE");
  CLI::Option* output =
      app->add_option("-o,--output", arguments->output,
                      "write the rig with the calibrations in use, or the one with --number")
          ->type_name("FILE")
          ->needs(rig);
  app->add_option("--number", arguments->number, "calibration to write")
      ->check(CLI::PositiveNumber)
      ->needs(output);
  app->add_flag("--json", arguments->json, "print one JSON object");
  set_examples(*app, {"infuse calibrations --camera front",
                      "infuse calibrations --rig rig.toml -o new.toml"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
