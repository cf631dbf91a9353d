#include "daemon/tools/calibrate_target/calibrate_target.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/protocol/number_json.hpp"
#include "daemon/tools/calibrate_target/target_views.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "fusion/target/calibrate_target.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kCalibrateTargetProgram = "infuse calibrate-target";

struct CalibrateTargetArguments {
  std::vector<std::string> drives;
  std::string camera;
  std::string board;
  std::string output;
  target::Board size;
  TargetViewOptions views;
  target::SolveTargetOptions solve;
  bool json = false;
};

/// Error relative to the ground truth of the drives.
struct TargetError {
  double rotation_deg;
  double translation_m;
};

std::optional<TargetError> error_to_truth(const TargetViews& views, const Eigen::Isometry3d& T) {
  if (!views.truth) return std::nullopt;
  const Eigen::AngleAxisd rotation(T.linear() * views.truth->linear().transpose());
  return TargetError{rotation.angle() / kDegree,
                     (T.translation() - views.truth->translation()).norm()};
}

Json to_json(const TargetViews& views, const target::TargetCalibration& calibration) {
  const target::TargetResult& result = calibration.result;
  Json list = Json::array();
  for (size_t i = 0; i < views.names.size(); ++i) {
    const target::ViewResidual& view = result.views[i];
    list.push_back({{"name", views.names[i]},
                    {"returns", calibration.return_counts[i]},
                    {"used", view.used},
                    {"rms_m", view.rms},
                    {"offset_m", view.offset},
                    {"tilt_deg", view.tilt / kDegree},
                    {"mahalanobis_distance", view.mahalanobis}});
    if (!calibration.reasons[i].empty()) list.back()["reason"] = calibration.reasons[i];
  }
  Json json = {{"T_camera_lidar", by_row(result.T_refcam_lidar.matrix())},
               {"covariance", by_row(result.covariance)},
               {"usable", result.usable()},
               {"views_used", result.used},
               {"range_noise_m", result.range_noise},
               {"misfit_m", result.misfit.offset},
               {"misfit_deg", result.misfit.tilt / kDegree},
               {"beam_bias_m", result.beam_bias},
               {"contrast_bias_m", result.contrast_bias},
               {"leave_one_out_ratio", result.leave_one_out},
               {"views", std::move(list)},
               {"skipped", views.skipped}};
  if (!result.usable()) json["reason"] = result.reason;
  if (const auto error = error_to_truth(views, result.T_refcam_lidar)) {
    json["error"] = {{"rotation_deg", error->rotation_deg},
                     {"translation_m", error->translation_m}};
  }
  return json;
}

std::string to_text(const TargetViews& views, const target::TargetCalibration& calibration) {
  const target::TargetResult& result = calibration.result;
  std::string text;
  for (size_t i = 0; i < views.names.size(); ++i) {
    const target::ViewResidual& view = result.views[i];
    text += fmt::format("  {:<28} ", views.names[i]);
    text += calibration.reasons[i].empty()
                ? fmt::format("{:5} returns, {:6.1f} mm and {:5.2f} deg residual{}\n",
                              calibration.return_counts[i], 1e3 * view.offset, view.tilt / kDegree,
                              view.used ? "" : ": outlier, not used")
                : calibration.reasons[i] + "\n";
  }
  constexpr size_t kMaxNotes = 5;
  for (size_t i = 0; i < std::min(views.skipped.size(), kMaxNotes); ++i)
    text += "  skipped: " + views.skipped[i] + "\n";
  if (views.skipped.size() > kMaxNotes)
    text += fmt::format("  and {} more were skipped\n", views.skipped.size() - kMaxNotes);
  if (result.used == 0) return text + "not usable: " + result.reason + "\n";
  const Eigen::Matrix4d& T = result.T_refcam_lidar.matrix();
  text += "T_camera_lidar\n";
  for (int row = 0; row < 3; ++row) {
    text += fmt::format("  {:10.6f} {:10.6f} {:10.6f} {:10.5f}\n", T(row, 0), T(row, 1), T(row, 2),
                        T(row, 3));
  }
  const auto sigma = result.covariance.diagonal().cwiseSqrt();
  text += fmt::format(
      "standard deviation: {:.3f} {:.3f} {:.3f} deg about, {:.1f} {:.1f} {:.1f} mm along the "
      "camera's axes\n",
      sigma(0) / kDegree, sigma(1) / kDegree, sigma(2) / kDegree, 1e3 * sigma(3), 1e3 * sigma(4),
      1e3 * sigma(5));
  text += fmt::format(
      "range: noise {:.1f} mm, biases of the beams {:.1f} mm, of bright returns {:+.1f} mm; boards "
      "off by {:.1f} mm, {:.2f} deg beyond noise\n",
      1e3 * result.range_noise, 1e3 * result.beam_bias, 1e3 * result.contrast_bias,
      1e3 * result.misfit.offset, result.misfit.tilt / kDegree);
  text += fmt::format(
      "{} of {} boards rejected; leaving one out changes the result by {:.1f} of its sigma\n",
      std::count_if(result.views.begin(), result.views.end(),
                    [](const auto& view) { return !view.used; }),
      result.views.size(), std::sqrt(result.leave_one_out));
  if (const auto error = error_to_truth(views, result.T_refcam_lidar)) {
    text += fmt::format("error relative to the truth: {:.3f} deg, {:.1f} mm\n", error->rotation_deg,
                        1e3 * error->translation_m);
  }
  text += result.usable() ? fmt::format("usable, from {} views\n", result.used)
                          : "not usable: " + result.reason + "\n";
  return text;
}

/// The drive's rig with the new extrinsics.
Result<void> write_result(const CalibrateTargetArguments& arguments, const TargetViews& views,
                          const target::TargetResult& result) {
  Rig rig = views.rig;
  for (CameraMount& camera : rig.cameras) {
    if (camera.name == views.camera) camera.T_camera_lidar = result.T_refcam_lidar;
  }
  return recording::write_rig(arguments.output, rig);
}

int run(CalibrateTargetArguments& arguments) {
  target::Board& board = arguments.size;
  if (!board.set_corners(arguments.board)) {
    return print_error(kCalibrateTargetProgram,
                       {"'" + arguments.board + "' is not COLSxROWS", "--board", "for example 7x5"},
                       kUsage);
  }
  for (const auto& wrong :
       {board.invalid(), arguments.views.invalid(), arguments.solve.invalid()}) {
    if (wrong) return print_error(kCalibrateTargetProgram, {*wrong, "", ""}, kUsage);
  }
  TargetViews views;
  for (const std::string& drive : arguments.drives) {
    const auto read = add_target_views(drive, arguments.camera, board, arguments.views, views);
    if (!read) return print_error(kCalibrateTargetProgram, read.error(), kUnreadable);
  }
  const target::TargetCalibration calibration = target::calibrate_target(
      views.observations, board, views.T_camera_lidar, arguments.views.returns, arguments.solve);
  const target::TargetResult& result = calibration.result;
  if (arguments.json) {
    std::cout << json_text(to_json(views, calibration)) << "\n";
  } else {
    std::cout << to_text(views, calibration);
  }
  if (!result.usable()) return kFailure;
  if (!arguments.output.empty()) {
    const auto written = write_result(arguments, views, result);
    if (!written) return print_error(kCalibrateTargetProgram, written.error(), kFailure);
  }
  return kDone;
}

}  // namespace

Command declare_calibrate_target(CLI::App& infuse) {
  CLI::App* app = add_tool(infuse, *find_tool("calibrate-target"));
  const auto arguments = std::make_shared<CalibrateTargetArguments>();
  app->add_option("DRIVE", arguments->drives, "drive folders of one rig, recorded standing still")
      ->required();
  app->add_option("--camera", arguments->camera, "camera, if the rig has several")
      ->type_name("NAME");
  app->add_option("--board", arguments->board, "inner corners of the board, e.g. 7x5")
      ->required()
      ->type_name("COLSxROWS");
  app->add_option("--square", arguments->size.square_size, "side length of a square")
      ->required()
      ->type_name("M");
  app->add_option("--range-accuracy", arguments->solve.errors.range_accuracy,
                  "range accuracy of the lidar by its manual, one standard deviation (0.02)")
      ->type_name("M");
  app->add_option("--margin", arguments->views.returns.margin,
                  "search margin around a board's position as predicted by the drive's extrinsics "
                  "(0.25)")
      ->type_name("M");
  app->add_option("-o,--output", arguments->output,
                  "write the rig with the result, if the result is usable")
      ->type_name("rig.toml");
  app->add_flag("--json", arguments->json, "print the result as one JSON object");
  set_examples(*app,
               {"infuse calibrate-target boards/ --board 7x5 --square 0.1 -o rig.toml",
                "infuse calibrate-target a/ b/ --camera left --board 9x6 --square 0.08 --json"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
