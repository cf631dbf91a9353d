#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/commands/command.hpp"
#include "daemon/protocol/counters_json.hpp"
#include "drivers/recording/kitti_import.hpp"

namespace infuse::daemon {
namespace {

struct Arguments {
  std::string folder;
  std::string drive;
  bool json = false;
};

int run(const Arguments& arguments) {
  const auto imported = recording::import_kitti(arguments.folder, arguments.drive);
  if (!imported) return complain("infuse import kitti", imported.error(), kUnreadable);
  if (arguments.json) {
    Json json = {{"layout", recording::to_string(imported->layout)},
                 {"drive", arguments.drive},
                 {"sweeps", imported->sweeps},
                 {"images", imported->images},
                 {"poses", imported->poses},
                 {"times_trusted", imported->times_trusted},
                 {"notes", Json::array()}};
    for (const Error& note : imported->notes) json["notes"].push_back(note.message());
    std::cout << json.dump() << "\n";
    return kDone;
  }
  std::cout << fmt::format("{}: {} sweeps, {} images, {} poses from KITTI's {} layout{}\n",
                           arguments.drive, imported->sweeps, imported->images, imported->poses,
                           recording::to_string(imported->layout),
                           imported->times_trusted ? "" : "; it has no times, they are made up");
  for (const Error& note : imported->notes) std::cout << "  note: " << note.message() << "\n";
  return kDone;
}

}  // namespace

Command declare_import(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand("import", "makes a drive of a public data set");
  app->require_subcommand(1);
  CLI::App* kitti = app->add_subcommand("kitti", "KITTI's raw, odometry and object layouts");
  const auto arguments = std::make_shared<Arguments>();
  kitti->add_option("DIR", arguments->folder, "folder of the data set")->required();
  kitti->add_option("-o,--output", arguments->drive, "drive folder to be made")
      ->required()
      ->type_name("DRIVE");
  kitti->add_flag("--json", arguments->json, "the result as one JSON object");
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
