#include <iostream>
#include <map>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/evaluation.hpp"
#include "daemon/owner/sharpness.hpp"
#include "daemon/protocol/json.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kEvaluateProgram = "infuse evaluate";

struct EvaluateArguments {
  std::string result;
  std::string truth;
  motion::Alignment alignment = motion::Alignment::kRigid;
  double span_s = 1;
  std::string sharpness;  // a drive
  std::string lidar;
  bool json = false;
};

/// True if the result is a rig or a calibration, not a trajectory.
bool is_calibration(const std::filesystem::path& result) {
  std::error_code ignored;
  return result.extension() == ".toml" || result.extension() == ".json" ||
         std::filesystem::is_directory(result, ignored);
}

template <class Score>
int print(const EvaluateArguments& arguments, const Result<Score>& score) {
  if (!score) return print_error(kEvaluateProgram, score.error(), kUnreadable);
  std::cout << (arguments.json ? json_text(to_json(*score)) + "\n" : to_text(*score));
  return kDone;
}

int run(const EvaluateArguments& arguments) {
  if (!arguments.sharpness.empty()) {
    return print(arguments, measure_sharpness(arguments.sharpness, arguments.lidar));
  }
  if (arguments.result.empty() || arguments.truth.empty()) {
    return print_error(kEvaluateProgram, {"RESULT and TRUTH are required, or --sharpness", "", ""},
                       kUsage);
  }
  if (!(arguments.span_s > 0 && arguments.span_s <= 1e6)) {
    return print_error(kEvaluateProgram, {"--span must be a number of seconds above 0", "", ""},
                       kUsage);
  }
  if (is_calibration(arguments.result)) {
    return print(arguments, score_rig(arguments.result, arguments.truth));
  }
  const auto score = score_trajectory(arguments.result, arguments.truth, arguments.alignment,
                                      from_seconds(arguments.span_s));
  const int code = print(arguments, score);
  return score && !score->absolute.usable() ? int{kFailure} : code;
}

}  // namespace

Command declare_evaluate(CLI::App& infuse) {
  const std::map<std::string, motion::Alignment> alignments = {
      {"none", motion::Alignment::kNone},
      {"first", motion::Alignment::kFirstPose},
      {"rigid", motion::Alignment::kRigid},
      {"similar", motion::Alignment::kSimilarity}};
  CLI::App* app = infuse.add_subcommand(
      "evaluate", "score a trajectory or a calibration, or the sharpness of a drive");
  const auto arguments = std::make_shared<EvaluateArguments>();
  app->add_option("RESULT", arguments->result,
                  "a trajectory (TUM or KITTI), or a calibration: a rig.toml, a drive, or the JSON "
                  "of infuse calibrate");
  app->add_option("TRUTH", arguments->truth, "the same, or a drive with truth");
  app->add_option(
         "--align", arguments->alignment,
         "alignment of a trajectory before scoring: none, first (first pose on first pose), "
         "rigid (least squares; the default) or similar (least squares with scale)")
      ->transform(CLI::CheckedTransformer(alignments))
      ->type_name("HOW");
  app->add_option("--span", arguments->span_s, "time span of the relative error (1)")
      ->type_name("SECONDS");
  CLI::Option* sharpness =
      app->add_option("--sharpness", arguments->sharpness,
                      "instead: how sharp the sweeps of a drive are on top of each other, as "
                      "measured and deskewed, in occupied voxels of 10 cm per point")
          ->type_name("DRIVE");
  app->add_option("--lidar", arguments->lidar, "its lidar, if there are several")
      ->type_name("NAME")
      ->needs(sharpness);
  app->add_flag("--json", arguments->json, "print the result as one JSON object");
  set_examples(*app, {"infuse evaluate track.tum drive/ --align first",
                      "infuse evaluate --sharpness drive/"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
