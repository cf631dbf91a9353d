#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/commands/command.hpp"
#include "daemon/protocol/json.hpp"
#include "drivers/import/kitti_import.hpp"
#include "drivers/import/opencalib_import.hpp"

namespace infuse::daemon {
namespace {

struct ImportArguments {
  std::string source;
  std::string drive;
  bool json = false;
};

int run_kitti(const ImportArguments& arguments) {
  const auto imported = importers::import_kitti(arguments.source, arguments.drive);
  if (!imported) return print_error("infuse import kitti", imported.error(), kUnreadable);
  if (arguments.json) {
    Json json = {{"layout", importers::name_of(imported->layout)},
                 {"drive", arguments.drive},
                 {"sweeps", imported->sweeps},
                 {"images", imported->images},
                 {"poses", imported->poses},
                 {"times_trusted", imported->times_trusted},
                 {"notes", Json::array()}};
    for (const Error& note : imported->notes) json["notes"].push_back(note.message());
    std::cout << json_text(json) << "\n";
    return kDone;
  }
  std::cout << fmt::format("{}: {} sweeps, {} images, {} poses from KITTI's {} layout{}\n",
                           arguments.drive, imported->sweeps, imported->images, imported->poses,
                           importers::name_of(imported->layout),
                           imported->times_trusted ? "" : "; it has no times, they are synthetic");
  for (const Error& note : imported->notes) std::cout << "  note: " << note.message() << "\n";
  return kDone;
}

int run_opencalib(const ImportArguments& arguments) {
  const auto imported = importers::import_opencalib(arguments.source, arguments.drive);
  if (!imported) return print_error("infuse import opencalib", imported.error(), kUnreadable);
  if (arguments.json) {
    std::cout << json_text({{"drive", arguments.drive}, {"sweeps", 1}, {"images", 1}}) << "\n";
  } else {
    std::cout << fmt::format("{}: a sweep and an image; their time is synthetic\n",
                             arguments.drive);
  }
  return kDone;
}

/// Declares the arguments that all sources share.
std::shared_ptr<ImportArguments> declare(CLI::App* app, const char* source,
                                         const char* description) {
  const auto arguments = std::make_shared<ImportArguments>();
  app->add_option(source, arguments->source, description)->required();
  app->add_option("-o,--output", arguments->drive, "drive folder to create")
      ->required()
      ->type_name("DRIVE");
  app->add_flag("--json", arguments->json, "print the result as one JSON object");
  return arguments;
}

}  // namespace

Command declare_import(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand("import", "convert a public data set to a drive");
  app->require_subcommand(1);
  CLI::App* kitti = app->add_subcommand("kitti", "KITTI's raw, odometry and object layouts");
  CLI::App* opencalib =
      app->add_subcommand("opencalib", "one scene of OpenCalib's lidar-to-camera data");
  const auto from_kitti = declare(kitti, "DIR", "folder of the data set");
  const auto from_opencalib =
      declare(opencalib, "FILE", "NAME.calib.txt; NAME.pcd and NAME.png or .jpg are next to it");
  set_examples(*app, {"infuse import kitti 2011_09_26/2011_09_26_drive_0005_sync -o drive/",
                      "infuse import opencalib scene/0.calib.txt -o drive/"});
  set_examples(*kitti, {"infuse import kitti 2011_09_26/2011_09_26_drive_0005_sync -o drive/",
                        "infuse import kitti dataset/sequences/07 -o drive/ --json"});
  set_examples(*opencalib, {"infuse import opencalib scene/0.calib.txt -o drive/",
                            "infuse import opencalib scene/0.calib.txt -o drive/ --json"});
  return {app, [=] {
            return kitti->parsed() ? run_kitti(*from_kitti) : run_opencalib(*from_opencalib);
          }};
}

}  // namespace infuse::daemon
