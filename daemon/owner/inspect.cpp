#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/progress_line.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/inspection.hpp"
#include "daemon/owner/inspection_list.hpp"
#include "drivers/recording/capture_parts.hpp"
#include "drivers/text/printable.hpp"

namespace infuse::daemon {
namespace {

struct InspectArguments {
  std::string path;
  std::string model;
  std::string calibration;
  bool json = false;
};

/// Inspects every capture of a folder: one line each, then totals.
int inspect_folder(const InspectArguments& arguments, const LidarOverrides& overrides) {
  InspectionList list;
  Json captures = Json::array();
  for (const auto& capture : recording::list_captures(arguments.path)) {
    ProgressLine line;
    const auto inspection = inspect_recording(capture, overrides, line);
    line.clear();
    const std::string text = list.add(capture, inspection);
    if (arguments.json) {
      captures.push_back(inspection ? to_json(*inspection)
                                    : Json{{"path", capture.string()},
                                           {"problems", {inspection.error().message()}}});
    } else {
      std::cout << text::printable(text, "\n") << std::flush;
    }
  }
  if (arguments.json) {
    std::cout << json_text({{"path", arguments.path},
                            {"captures", std::move(captures)},
                            {"totals", list.totals_json()}})
              << "\n";
  } else {
    std::cout << list.totals_text();
  }
  return list.all_have_lidars() ? kDone : kFailure;
}

int run(const InspectArguments& arguments) {
  const auto model = requested_model(arguments.model);
  if (!model) return print_error("infuse inspect", model.error(), kUsage);
  const LidarOverrides overrides{*model, arguments.calibration};
  if (recording::is_capture_folder(arguments.path)) return inspect_folder(arguments, overrides);
  ProgressLine line;
  const auto inspection = inspect_recording(arguments.path, overrides, line);
  line.clear();
  if (!inspection) return print_error("infuse inspect", inspection.error(), kUnreadable);
  std::cout << (arguments.json ? json_text(to_json(*inspection)) + "\n"
                               : text::printable(to_text(*inspection), "\n"));
  return has_lidar(*inspection) ? kDone : kFailure;
}

}  // namespace

Command declare_inspect(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand(
      "inspect",
      "list the contents of a capture or drive: sensors, rates, gaps, clocks, uses, problems");
  const auto arguments = std::make_shared<InspectArguments>();
  app->add_option(
         "PATH", arguments->path,
         "a drive folder, a pcap or pcapng file, or a folder of captures; the first part or a "
         "pattern of a split capture")
      ->required();
  app->add_option("--model", arguments->model, "model of the lidar, if it cannot be inferred")
      ->type_name("NAME");
  app->add_option("--calibration", arguments->calibration,
                  "db.xml of an HDL-64E, angle file of a Hesai")
      ->type_name("FILE");
  app->add_flag("--json", arguments->json, "print the result as one JSON object");
  set_examples(*app, {"infuse inspect drive.pcap", "infuse inspect captures/ --json"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
