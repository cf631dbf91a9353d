#include "daemon/tools/calibrate/calibrate.hpp"

#include <malloc.h>
#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <memory>
#include <random>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/progress_line.hpp"
#include "daemon/tools/calibrate/calibrate_arguments.hpp"
#include "daemon/tools/calibrate/calibration_comparison.hpp"
#include "daemon/tools/calibrate/calibration_format.hpp"
#include "daemon/tools/calibrate/calibration_report.hpp"
#include "daemon/tools/calibrate/calibration_run.hpp"
#include "daemon/tools/calibrate/scene_preparation.hpp"
#include "daemon/tools/calibrate/time_sigma.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "drivers/recording/rigid_matrix.hpp"
#include "drivers/text/numbers.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kCalibrateProgram = "infuse calibrate";

/// T_camera_lidar of the reference camera, as a rig.toml states it.
Result<Eigen::Isometry3d> read_rig_pose(const std::string& file, const ScenePairs& pairs) {
  const auto rig = recording::read_rig(file);
  if (!rig) return tl::unexpected(rig.error());
  const std::string& refcam = pairs.cameras.front().name;
  const CameraMount* mount = rig->find_camera(refcam);
  if (mount == nullptr) return fail("has no camera '" + refcam + "'", file);
  return mount->T_camera_lidar;
}

/// T_camera_lidar from 16 numbers or a rig.toml; the drive's extrinsics by default.
Result<Eigen::Isometry3d> read_initial_pose(const CalibrateArguments& arguments,
                                            const ScenePairs& pairs) {
  if (arguments.initial_pose.empty()) return pairs.cameras.front().T_camera_lidar;
  std::string text = arguments.initial_pose;
  std::replace(text.begin(), text.end(), ',', ' ');
  if (const auto numbers = text::parse_numbers(text); numbers && !numbers->empty()) {
    if (numbers->size() != 16) {
      return fail(fmt::format("has {} numbers; T_camera_lidar has 16, by row", numbers->size()),
                  "--start");
    }
    const auto rigid = recording::to_rigid(*numbers);
    if (!rigid) return fail("the 16 numbers are not a rigid transform", "--start");
    return *rigid;
  }
  return read_rig_pose(arguments.initial_pose, pairs);
}

int report_no_pairs(const CalibrateArguments& arguments, const ScenePairs& pairs) {
  const std::string reason = "no image has a sweep close to it in time";
  if (arguments.json) {
    std::cout << json_text({{"camera", pairs.cameras.front().name},
                            {"lidar", pairs.lidar},
                            {"usable", false},
                            {"reason", reason},
                            {"notes", pairs.notes}})
              << "\n";
  } else {
    std::cout << camera_names(pairs) << " against " << pairs.lidar << ": NOT USABLE: " << reason
              << "\n";
    for (const std::string& note : pairs.notes) std::cout << "  note: " << note << "\n";
  }
  return kFailure;
}

/// Leaves out scenes at which the vehicle's motion is not known, unless none remains: they say
/// nothing of a delay, and would be measured at another time than the others.
void leave_out_unknown_motion(ScenePairs& pairs) {
  std::vector<ScenePair> moving;
  for (const ScenePair& pair : pairs.pairs) {
    if (pair.twist) moving.push_back(pair);
  }
  const size_t left_out = pairs.pairs.size() - moving.size();
  if (left_out == 0 || moving.empty()) return;
  pairs.notes.push_back(
      fmt::format("{} of {} scenes left out: the vehicle's motion is not known there", left_out,
                  pairs.pairs.size()));
  pairs.pairs = std::move(moving);
}

Result<void> write_rig(const CalibrateArguments& arguments, const ScenePairs& pairs,
                       const CalibrationRun& run) {
  Rig rig = pairs.rig;
  for (size_t c = 0; c < pairs.cameras.size(); ++c) {
    for (CameraMount& camera : rig.cameras) {
      if (camera.name != pairs.cameras[c].name) continue;
      camera.T_camera_lidar = T_camera_refcam(pairs, c) * run.result.T_refcam_lidar;
      camera.intrinsics = run.cameras[c].model.intrinsics();
      if (run.refined && run.refined->refined) {
        const Eigen::Vector4d variance = run.refined->cameras[c].covariance.diagonal();
        camera.intrinsics_sigma = {std::sqrt(variance(0)),
                                   std::sqrt(variance.segment<2>(1).maxCoeff()),
                                   std::sqrt(variance(3))};
      }
      if (const auto delay = refined_delay(run, pairs)) {
        camera.stamp_delay = from_seconds(*delay);
        camera.stamp_delay_sigma = from_seconds(run.delay->sigma);
      }
    }
  }
  return recording::write_rig(arguments.output, rig);
}

/// Compares the first result with the rig of `--compare`, where that is wanted and there is one.
Result<std::optional<ComparedExtrinsics>> compare_with_old(
    const CalibrateArguments& arguments, ScenePairs& held_out,
    const std::optional<Eigen::Isometry3d>& T_old, const CalibrationRun& run) {
  if (!T_old || !run.result.has_pose) return std::nullopt;
  const std::vector<calibration::Scene> scenes = move_scenes(held_out, 0);
  std::optional<geometry::Matrix6> covariance;
  if (run.result.uncertainty.usable()) covariance = run.result.covariance();
  const ComparedExtrinsics compared =
      compare_on(held_out, scenes, *T_old, run.result.T_refcam_lidar, covariance);
  if (!arguments.overlays.empty()) {
    if (auto written = write_overlays(arguments.overlays, held_out, compared); !written) {
      return tl::unexpected(written.error());
    }
  }
  return compared;
}

CalibrationKind kind_of(const CalibrateArguments& arguments) {
  if (arguments.refine_intrinsics) return CalibrationKind::kIntrinsics;
  if (arguments.refine_delay) return CalibrationKind::kDelay;
  return arguments.within_deg == kAnyHeadingDeg ? CalibrationKind::kAnyHeading
                                                : CalibrationKind::kPose;
}

calibration::CalibrateOptions calibrate_options(const CalibrateArguments& arguments,
                                                const std::vector<CameraMount>& cameras) {
  calibration::CalibrateOptions options;
  options.screen.half_width = arguments.within_deg * kDegree;
  options.seed = arguments.seed;
  options.splits = 4;
  options.known = known_parameters(arguments, cameras, default_time_sigma(cameras).sigma);
  options.max_rotation_sigma = arguments.max_sigma[0] * kDegree;
  options.max_translation_sigma = arguments.max_sigma[1];
  return options;
}

/// The initial pose, and the extrinsics to compare with; `wrong` becomes the exit status of an
/// error.
Result<PreparationOptions> prepare_for(const CalibrateArguments& arguments, const ScenePairs& pairs,
                                       ExitCode& wrong) {
  PreparationOptions out;
  wrong = kUsage;
  const auto initial_pose = read_initial_pose(arguments, pairs);
  if (!initial_pose) return tl::unexpected(initial_pose.error());
  std::mt19937_64 random(arguments.seed);  // the same initial pose for every measure
  out.T_refcam_lidar =
      perturb(*initial_pose, arguments.perturb[0] * kDegree, arguments.perturb[1], random);
  wrong = kUnreadable;
  if (!arguments.compare.empty()) {
    const auto old = read_rig_pose(arguments.compare, pairs);
    if (!old) return tl::unexpected(old.error());
    out.T_old = *old;
  }
  for (const std::string& measure : arguments.measures) {
    out.measures.push_back(calibration::find_measure(measure));
  }
  out.calibrate = calibrate_options(arguments, pairs.cameras);
  out.kind = kind_of(arguments);
  out.draw = !arguments.report.empty() || !arguments.overlays.empty();
  return out;
}

/// Prints one object: the first measure's result, with the others under `measures`.
void print(const CalibrateArguments& arguments, const ScenePairs& pairs,
           const std::vector<CalibrationRun>& runs,
           const std::optional<ComparedExtrinsics>& compared) {
  if (!arguments.json) {
    for (const CalibrationRun& run : runs) std::cout << to_text(run, pairs);
    if (compared) std::cout << to_text(*compared);
    return;
  }
  Json json = to_json(runs.front(), pairs);
  if (runs.size() > 1) {
    json["measures"] = Json::array();
    for (size_t k = 1; k < runs.size(); ++k) json["measures"].push_back(to_json(runs[k], pairs));
  }
  if (compared) json["comparison"] = to_json(*compared);
  std::cout << json_text(json) << "\n";
}

/// Keeps what is freed: every scene and level takes large blocks again, which the kernel would
/// clear each time (mallopt(3)).
void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

/// Writes the rig that was asked for, if the result is usable.
int write_usable(const CalibrateArguments& arguments, const ScenePairs& pairs,
                 const CalibrationRun& run) {
  const bool usable = run.result.usable();
  if (arguments.output.empty()) return usable ? kDone : kFailure;
  if (!usable) {
    std::cerr << kCalibrateProgram << ": " << arguments.output
              << " not written: the result is not usable\n";
    return kFailure;
  }
  if (auto written = write_rig(arguments, pairs, run); !written) {
    return print_error(kCalibrateProgram, written.error(), kUnreadable);
  }
  return kDone;
}

int run(const CalibrateArguments& arguments) {
  keep_freed_memory();
  if (const auto wrong = find_usage_error(arguments)) {
    return print_error(kCalibrateProgram, {*wrong, "", ""}, kUsage);
  }
  ProgressLine line;
  SceneRequest request = arguments.request;
  if (!arguments.compare.empty()) request.max_scenes *= 2;  // half of them are held out
  ExitCode wrong = kUnreadable;
  std::optional<PreparationOptions> prepared;
  std::optional<ScenePreparation> preparation;
  const auto prepare = [&](ScenePairs& so_far, ScenePair& pair) -> Result<void> {
    if (!preparation) {
      auto options = prepare_for(arguments, so_far, wrong);
      if (!options) return tl::unexpected(options.error());
      preparation.emplace(prepared.emplace(std::move(*options)));
    }
    return preparation->prepare(so_far, pair);
  };
  auto pairs = read_scene_pairs(
      request, [&](double share) { line.show(0.5 * share, "reading"); }, prepare);
  if (!pairs) {
    line.clear();
    return print_error(kCalibrateProgram, pairs.error(), wrong);
  }
  if (!prepared) {  // without pairs the arguments are still to be checked
    line.clear();
    if (auto options = prepare_for(arguments, *pairs, wrong); !options) {
      return print_error(kCalibrateProgram, options.error(), wrong);
    }
    return report_no_pairs(arguments, *pairs);
  }
  if (arguments.refine_delay) {
    leave_out_unknown_motion(*pairs);
  } else if (const std::string note = default_time_sigma(pairs->cameras).note;
             !arguments.time_sigma_ms && !note.empty()) {
    pairs->notes.push_back(note);
  }
  ScenePairs held_out;
  if (prepared->T_old) held_out = hold_out(*pairs);
  std::vector<CalibrationRun> runs;
  for (size_t k = 0; k < arguments.measures.size(); ++k) {
    line.show(0.5 + 0.5 * static_cast<double>(k) / static_cast<double>(arguments.measures.size()),
              fmt::format("{} scenes, {}", pairs->pairs.size(), arguments.measures[k]));
    runs.push_back(run_calibration(*pairs, move_scenes(*pairs, k), *prepared->measures[k],
                                   prepared->T_refcam_lidar, prepared->calibrate, prepared->kind));
  }
  if (!arguments.report.empty()) {
    line.show(0.99, "drawing the report");
    if (auto written = write_report(arguments.report, *pairs, runs); !written) {
      line.clear();
      return print_error(kCalibrateProgram, written.error(), kUnreadable);
    }
  }
  const auto compared = compare_with_old(arguments, held_out, prepared->T_old, runs.front());
  line.clear();
  if (!compared) return print_error(kCalibrateProgram, compared.error(), kUnreadable);
  print(arguments, *pairs, runs, *compared);
  return write_usable(arguments, *pairs, runs.front());
}

}  // namespace

Command declare_calibrate(CLI::App& infuse) {
  CLI::App* app = add_tool(infuse, *find_tool("calibrate"));
  const auto arguments = std::make_shared<CalibrateArguments>();
  declare_arguments(*app, *arguments);
  set_examples(*app, {"infuse calibrate drive/ --camera front -o rig.toml",
                      "infuse calibrate monday/ tuesday/ --compare old.toml --report report/"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
