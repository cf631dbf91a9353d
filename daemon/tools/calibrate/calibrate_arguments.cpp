#include "daemon/tools/calibrate/calibrate_arguments.hpp"

#include <algorithm>

#include "fusion/calibration/named_measures.hpp"

namespace infuse::daemon {
namespace {

constexpr double kMaxScreenedDeg = 45;

std::string measure_names() {
  std::string names;
  for (const auto& measure : calibration::named_measures()) {
    names += (names.empty() ? "" : ", ") + std::string(measure.name);
  }
  return names;
}

/// What is calibrated, and from where the search begins.
void declare_inputs(CLI::App& app, CalibrateArguments& arguments) {
  app.add_option("DRIVE", arguments.request.drives, "drive folders of one rig")->required();
  app.add_option("--camera", arguments.request.cameras,
                 "camera, if the rig has several; for a rig of cameras, names separated by commas: "
                 "the first is the reference camera, the others keep their pose relative to it")
      ->delimiter(',')
      ->type_name("NAME");
  app.add_option("--lidar", arguments.request.lidar,
                 "lidar (default: the one that the camera's extrinsics refer to)")
      ->type_name("NAME");
  app.add_option("--measure", arguments.measures,
                 "measure of dependence to maximise (joint), one of " + measure_names() +
                     "; several are compared, the first one gives the result")
      ->type_name("NAME");
  app.add_option("--scenes", arguments.request.max_scenes,
                 "maximum number of images of each camera (20)")
      ->type_name("N");
  app.add_option("--start", arguments.initial_pose,
                 "initial guess of T_camera_lidar: 16 numbers by row, or a rig.toml (default: the "
                 "drive's extrinsics)")
      ->type_name("MATRIX|RIG");
  app.add_option("--within", arguments.within_deg,
                 "maximum rotation error of the initial guess about each axis (3.5), at most 45; "
                 "180: any heading, within 20 of upright and 0.9 m of the position")
      ->type_name("DEG");
  app.add_option("--perturb", arguments.perturb,
                 "perturb the initial guess at random by up to so many degrees and metres, to test "
                 "the convergence")
      ->expected(2)
      ->delimiter(',')
      ->type_name("DEG,M");
}

}  // namespace

void declare_arguments(CLI::App& app, CalibrateArguments& arguments) {
  declare_inputs(app, arguments);
  app.add_option("--intrinsics-sigma", arguments.intrinsics_sigma,
                 "standard deviations to which focal length, principal point and k1 are known: "
                 "part of the stated covariance (intrinsics_sigma of the rig; without that "
                 "0.2,0.5,0.005, a careful calibration with a board)")
      ->expected(3)
      ->delimiter(',')
      ->type_name("PERCENT,PX,K1");
  app.add_flag("--unknown-intrinsics", arguments.unknown_intrinsics,
               "nobody has calibrated the cameras: only what the scenes show bounds the errors of "
               "their intrinsics")
      ->excludes("--intrinsics-sigma");
  app.add_option("--time-sigma", arguments.time_sigma_ms,
                 "standard deviation of the time between image and sweep, likewise (1; 9.6 for a "
                 "rolling shutter without stamp_delay_sigma_ms)")
      ->type_name("MS");
  app.add_flag("--refine-intrinsics", arguments.refine_intrinsics,
               "estimate focal length, principal point and k1 of every camera as well; not usable "
               "where the scenes do not determine them");
  app.add_flag("--refine-delay", arguments.refine_delay,
               "estimate the delay of the camera's stamps as well, within 100 ms of what the drive "
               "states; not usable where the motion does not determine it");
  app.add_option("--max-sigma", arguments.max_sigma,
                 "maximum stated standard deviations of a usable result (0.2,0.05)")
      ->expected(2)
      ->delimiter(',')
      ->type_name("DEG,M");
  app.add_option("--seed", arguments.seed, "seed of the random numbers (1)")->type_name("N");
  app.add_option("--compare", arguments.compare,
                 "compare the result with the extrinsics of a rig.toml, on as many further images "
                 "that are held out")
      ->type_name("RIG");
  app.add_option("--overlays", arguments.overlays,
                 "of --compare: write returns over images with both, side by side, as a PNG image")
      ->type_name("FILE");
  app.add_option("--report", arguments.report, "write a report with images: DIR/index.html")
      ->type_name("DIR");
  app.add_option("-o,--output", arguments.output,
                 "write the rig with the result, if the result is usable")
      ->type_name("rig.toml");
  app.add_flag("--json", arguments.json, "print the result as one JSON object");
}

calibration::KnownParameters known_parameters(const CalibrateArguments& arguments,
                                              std::span<const CameraMount> cameras,
                                              Duration time_sigma) {
  if (const auto& ms = arguments.time_sigma_ms) {
    time_sigma = from_seconds(1e-3 * std::clamp(*ms, -1.0, 1e3));
  }
  calibration::KnownParameters known{.intrinsics_stated = !arguments.unknown_intrinsics,
                                     .time_sigma = time_sigma};
  const auto state = [&](const IntrinsicsSigma& sigma) {
    known.focal_sigma = sigma.focal_length;
    known.principal_point_sigma = sigma.principal_point;
    known.radial_sigma = sigma.radial;
  };
  if (const std::vector<double>& given = arguments.intrinsics_sigma; !given.empty()) {
    state({given[0] / 100, given[1], given[2]});
    return known;
  }
  const IntrinsicsSigma usual{known.focal_sigma, known.principal_point_sigma, known.radial_sigma};
  IntrinsicsSigma largest;
  for (const CameraMount& camera : cameras) {
    const IntrinsicsSigma one = camera.intrinsics_sigma.value_or(usual);
    largest = {std::max(largest.focal_length, one.focal_length),
               std::max(largest.principal_point, one.principal_point),
               std::max(largest.radial, one.radial)};
  }
  if (!cameras.empty()) state(largest);
  return known;
}

std::optional<std::string> find_usage_error(const CalibrateArguments& arguments) {
  if (arguments.request.max_scenes < 1 || arguments.request.max_scenes > 1000) {
    return "--scenes must be between 1 and 1000";
  }
  if (!(arguments.within_deg >= 0 && arguments.within_deg <= kMaxScreenedDeg) &&
      arguments.within_deg != kAnyHeadingDeg) {
    return "--within must be between 0 and 45, or be 180";
  }
  if (!(arguments.perturb[0] >= 0 && arguments.perturb[0] <= 45 && arguments.perturb[1] >= 0 &&
        arguments.perturb[1] <= 10)) {
    return "--perturb must be at most 45 degrees and 10 m";
  }
  if (!(arguments.max_sigma[0] > 0 && arguments.max_sigma[1] > 0)) {
    return "--max-sigma must be positive";
  }
  if (const auto wrong = known_parameters(arguments).invalid()) {
    return "--intrinsics-sigma, --time-sigma: " + *wrong;
  }
  if (arguments.refine_intrinsics && arguments.refine_delay) {
    return "--refine-intrinsics and --refine-delay exclude each other";
  }
  if (arguments.refine_intrinsics || arguments.refine_delay) {
    if (arguments.within_deg == kAnyHeadingDeg) {
      return "--within 180 excludes --refine-intrinsics and --refine-delay: calibrate first, then "
             "refine from --start RIG";
    }
    const std::string option = arguments.refine_delay ? "--refine-delay" : "--refine-intrinsics";
    if (arguments.measures.size() > 1) return option + " takes one measure";
    if (arguments.refine_delay && arguments.request.cameras.size() > 1) {
      return option + " takes one camera";
    }
    if (!arguments.compare.empty()) {
      return option +
             " and --compare exclude each other: extrinsics are compared with the same intrinsics "
             "and times";
    }
  }
  if (!arguments.overlays.empty() && arguments.compare.empty()) {
    return "--overlays needs --compare";
  }
  for (const std::string& name : arguments.measures) {
    if (calibration::find_measure(name) != nullptr) continue;
    return "unknown measure '" + name + "'; known: " + measure_names();
  }
  return std::nullopt;
}

}  // namespace infuse::daemon
