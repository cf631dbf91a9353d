#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/playback/calibration_scenes.hpp"
#include "fusion/calibration/model_check.hpp"

namespace infuse::daemon {

/// `--within` of an initial guess of any heading.
inline constexpr double kAnyHeadingDeg = 180;

/// What the command line of `infuse calibrate` states.
struct CalibrateArguments {
  SceneRequest request;
  std::vector<std::string> measures{"joint"};
  std::string initial_pose;
  std::vector<double> perturb{0, 0};  // deg, m
  double within_deg = 3.5;
  std::vector<double> intrinsics_sigma;  // %, px, of k1; empty: what the rig states
  bool unknown_intrinsics = false;
  std::optional<double> time_sigma_ms;
  std::vector<double> max_sigma{0.2, 0.05};  // deg, m
  uint64_t seed = 1;
  bool refine_intrinsics = false, refine_delay = false;
  std::string compare;
  std::string overlays;
  std::string report;
  std::string output;
  bool json = false;
};

/// Adds the options, which set `arguments`.
void declare_arguments(CLI::App& app, CalibrateArguments& arguments);

/// What is wrong with the arguments, or nothing.
std::optional<std::string> find_usage_error(const CalibrateArguments& arguments);

/// To what intrinsics and times are known: as the arguments state; else the intrinsics as the rig
/// states of the `cameras`, the least known of each, and the time to `time_sigma`. A camera of
/// which it states nothing has the defaults of `KnownParameters`.
calibration::KnownParameters known_parameters(const CalibrateArguments& arguments,
                                              std::span<const CameraMount> cameras = {},
                                              Duration time_sigma = {});

}  // namespace infuse::daemon
