#include <iostream>
#include <map>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/evaluation.hpp"
#include "daemon/protocol/json.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kEvaluateProgram = "infuse evaluate";

struct EvaluateArguments {
  std::string result;
  std::string truth;
  motion::Alignment alignment = motion::Alignment::kRigid;
  double span_s = 1;
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
  CLI::App* app = infuse.add_subcommand("evaluate", "score a trajectory or a calibration");
  const auto arguments = std::make_shared<EvaluateArguments>();
  app->add_option("RESULT", arguments->result,
                  "a trajectory (TUM or KITTI), or a calibration: a rig.toml, a drive, or the JSON "
                  "of infuse calibrate")
      ->required();
  app->add_option("TRUTH", arguments->truth, "the same, or a drive with truth")->required();
  app->add_option(
         "--align", arguments->alignment,
         "alignment of a trajectory before scoring: none, first (first pose on first pose), "
         "rigid (least squares; the default) or similar (least squares with scale)")
      ->transform(CLI::CheckedTransformer(alignments))
      ->type_name("HOW");
  app->add_option("--span", arguments->span_s, "time span of the relative error (1)")
      ->type_name("SECONDS");
  app->add_flag("--json", arguments->json, "print the result as one JSON object");
  set_examples(*app, {"infuse evaluate track.tum drive/ --align first",
                      "infuse evaluate rig.toml drive/ --json"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
