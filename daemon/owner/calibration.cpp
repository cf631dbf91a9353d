#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/owner/calibration_reports.hpp"
#include "daemon/owner/client.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/report_text.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/protocol/number_json.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/drive_toml.hpp"

namespace infuse::daemon {
namespace {

struct CalibrationArguments {
  std::string socket;
  std::string camera;
  bool off = false;
  uint64_t number = 0;  // 0: none
  std::string rig;
  bool json = false;
};

std::string matrix_text(const Json& numbers) {
  std::string lines;
  for (size_t row = 0; row < 3 && numbers.size() == 16; ++row) {
    lines += "     ";
    for (size_t column = 0; column < 4; ++column) {
      lines += fmt::format(" {:10.6f}", numbers[4 * row + column].get<double>());
    }
    lines += "\n";
  }
  return lines;
}

/// "+0.01 ± 0.02, …" of three axes from index `from` on; `factor` converts to the printed unit.
std::string offset_text(const Json& offset, const Json& sigma, size_t from, double factor) {
  std::string list;
  for (size_t i = from; i < from + 3; ++i) {
    const double axis_sigma = sigma[i].get<double>();
    list += i == from ? "" : ", ";
    list += axis_sigma > 1e8 ? std::string("unknown")
                             : fmt::format("{:+.2f} ± {:.2f}", offset[i].get<double>() * factor,
                                           axis_sigma * factor);
  }
  return list;
}

std::string calibration_text(const Json& report) {
  std::string lines =
      fmt::format("{}: {} since {}, {}{}\n", text_of(report, "device"), text_of(report, "state"),
                  utc_text(report, "since"), text_of(report, "policy"),
                  report.value("frozen", false) ? ", frozen" : "");
  lines += fmt::format("  in use: T_camera_lidar\n{}",
                       matrix_text(report.value("T_camera_lidar", Json::array())));
  if (report.value("proposed", false)) {
    lines += "  a new calibration waits: infuse calibrations, infuse apply\n";
  }
  if (report.value("recalibration_requested", false)) {
    lines += fmt::format("  requested re-estimation: {} of {} scenes\n", report.value("scenes", 0),
                         report.value("needed_scenes", 0));
  }
  if (report.contains("camera_fault")) {
    lines += fmt::format("  camera fault: {}{}\n", text_of(report, "camera_fault"),
                         report.contains("images_of") ? ": its images are those of the camera " +
                                                            text_of(report, "images_of")
                                                      : "");
  }
  if (report.contains("evidence")) {
    const Json& evidence = report["evidence"];
    lines += fmt::format(
        "  {} images evaluated; evidence of a drift {:.1f}, threshold {:.1f} nats ({})\n",
        report.value("evaluations", uint64_t{0}), evidence.value("nats", 0.0),
        evidence.value("threshold_nats", 0.0), text_of(evidence, "axis"));
    lines += fmt::format("  estimated error ({})°, ({}) cm\n",
                         offset_text(report["offset"], report["offset_sigma"], 0, 1 / kDegree),
                         offset_text(report["offset"], report["offset_sigma"], 3, 100));
  }
  if (report.contains("estimate")) {
    const Json& estimate = report["estimate"];
    lines += fmt::format(
        "  last estimate, from {} scenes, {}\n{}", estimate.value("scenes", 0),
        estimate.value("usable", false) ? "usable" : "not usable: " + text_of(estimate, "reason"),
        matrix_text(estimate["T_camera_lidar"]));
  }
  lines += "  history\n";
  for (const Json& change : report.value("history", Json::array())) {
    lines += fmt::format("    {} {}: {}\n", utc_text(change, "stamp"), text_of(change, "state"),
                         text_of(change, "what"));
  }
  return lines;
}

int print_calibration(const CalibrationArguments& arguments) {
  constexpr const char* kProgram = "infuse calibration";
  const auto reports = poll_calibrations(arguments.socket, arguments.camera);
  if (!reports) return print_error(kProgram, reports.error(), kFailure);
  for (const Json& report : *reports) {
    std::cout << (arguments.json ? json_text(report) + "\n" : calibration_text(report));
  }
  return kDone;
}

/// Sends a request and prints the daemon's answer if there is more to it than that it was carried
/// out.
int send_request(const std::string& program, Client& client, const Json& request) {
  if (auto sent = client.send(request); !sent) return print_error(program, sent.error(), kFailure);
  const auto message = client.next(std::chrono::seconds(5));
  if (!message) return print_error(program, message.error(), kFailure);
  if (!*message) return print_error(program, {"the daemon ended", "", ""}, kFailure);
  if (text_of(**message, "class") == "ACK") {
    if (const std::string note = text_of(**message, "note"); !note.empty()) {
      std::cout << note << "\n";
    }
    return kDone;
  }
  return print_error(program, {text_of(**message, "what"), "", text_of(**message, "hint")},
                     kFailure);
}

int send_request(const char* op, const CalibrationArguments& arguments) {
  const std::string program = std::string("infuse ") + op;
  auto client = Client::connect(arguments.socket);
  if (!client) return print_error(program, client.error(), kFailure);
  Json request = {{"op", op}};
  if (!arguments.camera.empty()) request["device"] = arguments.camera;
  if (arguments.off) request["on"] = false;
  if (arguments.number > 0) request["number"] = arguments.number;
  return send_request(program, *client, request);
}

/// Puts the calibrations of a rig.toml into use, camera by camera.
int apply_rig(const CalibrationArguments& arguments) {
  constexpr const char* kProgram = "infuse apply";
  const auto rig = recording::read_rig(arguments.rig);
  if (!rig) return print_error(kProgram, rig.error(), kUnreadable);
  auto client = Client::connect(arguments.socket);
  if (!client) return print_error(kProgram, client.error(), kFailure);
  bool any = false;
  for (const CameraMount& camera : rig->cameras) {
    if (!arguments.camera.empty() && camera.name != arguments.camera) continue;
    any = true;
    const int code = send_request(kProgram, *client,
                                  {{"op", "apply"},
                                   {"device", camera.name},
                                   {"T_camera_lidar", by_row(camera.T_camera_lidar.matrix())}});
    if (code != kDone) return code;
  }
  if (any) return kDone;
  return print_error(kProgram, {"no such camera", arguments.rig, "see --camera"}, kUsage);
}

using Examples = std::initializer_list<const char*>;

CLI::App* declare(CLI::App& infuse, const char* name, const char* description, Examples examples,
                  const std::shared_ptr<CalibrationArguments>& arguments) {
  CLI::App* app = infuse.add_subcommand(name, description);
  app->add_option("--camera", arguments->camera, "camera (default: all)")->type_name("NAME");
  app->add_option("--socket", arguments->socket, "socket of the daemon")->type_name("PATH");
  set_examples(*app, examples);
  return app;
}

Command declare_request(CLI::App& infuse, const char* op, const char* description,
                        Examples examples) {
  const auto arguments = std::make_shared<CalibrationArguments>();
  CLI::App* app = declare(infuse, op, description, examples, arguments);
  return {app, [op, arguments] { return send_request(op, *arguments); }};
}

}  // namespace

Command declare_calibration(CLI::App& infuse) {
  const auto arguments = std::make_shared<CalibrationArguments>();
  CLI::App* app =
      declare(infuse, "calibration",
              "print the running daemon's calibrations, their monitoring state and history",
              {"infuse calibration", "infuse calibration --camera front --json"}, arguments);
  app->add_flag("--json", arguments->json, "print the CALIBRATION reports, one per line");
  return {app, [arguments] { return print_calibration(*arguments); }};
}

Command declare_recalibrate(CLI::App& infuse) {
  return declare_request(infuse, "recalibrate", "request a new estimate of a camera's extrinsics",
                         {"infuse recalibrate", "infuse recalibrate --camera front"});
}

Command declare_apply(CLI::App& infuse) {
  const auto arguments = std::make_shared<CalibrationArguments>();
  CLI::App* app =
      declare(infuse, "apply", "put proposed, earlier or given extrinsics into use",
              {"infuse apply 7", "infuse apply --rig rig.toml --camera front"}, arguments);
  CLI::Option* number =
      app->add_option("NUMBER", arguments->number,
                      "of infuse calibrations (default: the one that is proposed)")
          ->check(CLI::PositiveNumber);
  app->add_option("--rig", arguments->rig, "use the extrinsics of a rig.toml")
      ->type_name("FILE")
      ->excludes(number);
  return {app, [arguments] {
            return arguments->rig.empty() ? send_request("apply", *arguments)
                                          : apply_rig(*arguments);
          }};
}

Command declare_rollback(CLI::App& infuse) {
  return declare_request(infuse, "rollback", "return to the previous extrinsics",
                         {"infuse rollback", "infuse rollback --camera front"});
}

Command declare_freeze(CLI::App& infuse) {
  const auto arguments = std::make_shared<CalibrationArguments>();
  CLI::App* app = declare(infuse, "freeze", "keep the daemon from changing calibrations on its own",
                          {"infuse freeze --camera front", "infuse freeze --off"}, arguments);
  app->add_flag("--off", arguments->off, "allow changes again");
  return {app, [arguments] { return send_request("freeze", *arguments); }};
}

}  // namespace infuse::daemon
