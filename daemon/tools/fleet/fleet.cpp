#include "daemon/tools/fleet/fleet.hpp"

#include <iostream>
#include <memory>
#include <sstream>

#include "daemon/command_line/arguments.hpp"
#include "daemon/tools/fleet/fleet_page.hpp"
#include "drivers/recording/atomic_file.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kFleetProgram = "infuse fleet";
constexpr size_t kMaxListBytes = size_t{64} << 20;

struct FleetDriveArguments {
  std::string steps, output;
  DriveName name;
};

struct FleetPoolArguments {
  std::vector<std::string> entries, rigs;
  std::string list, output, page;
  calibration::PoseDriftOptions options;
};

Result<void> write_whole(const std::string& path, const std::string& text) {
  return recording::write_file_atomically(path, std::as_bytes(std::span(text)));
}

int run_fleet_drive(const FleetDriveArguments& arguments) {
  if (const auto wrong = arguments.name.invalid()) {
    return print_error(kFleetProgram, {*wrong, "", ""}, kUsage);
  }
  const auto entry = make_drive_entry(arguments.steps, arguments.name);
  if (!entry) return print_error(kFleetProgram, entry.error(), kUnreadable);
  const auto written = write_whole(arguments.output, json_text(*entry) + "\n");
  if (!written) return print_error(kFleetProgram, written.error(), kUnreadable);
  return kDone;
}

/// Rigs by vehicle, of arguments VEHICLE=FILE.
Result<std::map<std::string, Rig>> read_rigs(const std::vector<std::string>& arguments) {
  std::map<std::string, Rig> rigs;
  for (const std::string& argument : arguments) {
    const size_t equals = argument.find('=');
    if (equals == 0 || equals == argument.npos) {
      return fail("'" + argument + "' is not VEHICLE=FILE", "--rig");
    }
    auto rig = recording::read_rig(argument.substr(equals + 1));
    if (!rig) return tl::unexpected(rig.error());
    rigs.insert_or_assign(argument.substr(0, equals), std::move(*rig));
  }
  return rigs;
}

/// The files that the arguments name.
Result<std::vector<std::string>> entry_files(const FleetPoolArguments& arguments) {
  std::vector<std::string> files = arguments.entries;
  if (!arguments.list.empty()) {
    const auto text = text::read_text(arguments.list, kMaxListBytes);
    if (!text) return tl::unexpected(text.error());
    std::istringstream lines(*text);
    for (std::string line; std::getline(lines, line);) {
      if (!line.empty()) files.push_back(line);
    }
  }
  if (files.empty()) return fail("no entries of drives are given");
  return files;
}

/// Reads an entry; one that cannot be read is a drive that failed.
DriveEntry read_or_name(const std::filesystem::path& path) {
  auto entry = read_drive_entry(path);
  if (entry) return std::move(*entry);
  const std::string folder = path.parent_path().filename().string();
  return {.vehicle = folder.empty() ? "?" : folder,
          .drive = path.stem().string(),
          .failures = {{"entry", entry.error().message()}}};
}

int run_fleet_pool(const FleetPoolArguments& arguments) {
  if (const auto wrong = arguments.options.invalid()) {
    return print_error(kFleetProgram, {*wrong, "--significance", ""}, kUsage);
  }
  const auto files = entry_files(arguments);
  if (!files) return print_error(kFleetProgram, files.error(), kUsage);
  const auto rigs = read_rigs(arguments.rigs);
  if (!rigs) return print_error(kFleetProgram, rigs.error(), kUnreadable);
  std::vector<DriveEntry> entries;
  for (const std::string& file : *files) entries.push_back(read_or_name(file));
  const FleetSummary fleet = summarise_fleet(std::move(entries), *rigs, arguments.options);
  if (!arguments.page.empty()) {
    const auto written = write_whole(arguments.page, make_fleet_page(fleet));
    if (!written) return print_error(kFleetProgram, written.error(), kUnreadable);
  }
  const std::string json = json_text(to_json(fleet)) + "\n";
  if (arguments.output.empty()) {
    std::cout << json;
    return kDone;
  }
  const auto written = write_whole(arguments.output, json);
  if (!written) return print_error(kFleetProgram, written.error(), kUnreadable);
  return kDone;
}

void declare_fleet_drive(CLI::App& app, FleetDriveArguments& arguments) {
  CLI::App* drive =
      app.add_subcommand("drive", "make the entry of a drive from what was run on it");
  drive
      ->add_option("STEPS", arguments.steps,
                   "folder with NAME.code (exit code), NAME.json (standard output) and NAME.log "
                   "(standard error) of each step: calibrate, calibrate-CAMERA, replay, map")
      ->required();
  drive->add_option("--vehicle", arguments.name.vehicle, "name of the vehicle")
      ->required()
      ->type_name("NAME");
  drive->add_option("--drive", arguments.name.drive, "name of the drive")
      ->required()
      ->type_name("NAME");
  drive
      ->add_option("--date", arguments.name.date,
                   "date of the drive (default: the stamp of its first image)")
      ->type_name("YYYY-MM-DD");
  drive->add_option("-o,--output", arguments.output, "entry to write")
      ->required()
      ->type_name("FILE.json");
  set_examples(
      *drive, {"infuse fleet drive steps/ --vehicle car7 --drive monday -o car7/monday.json",
               "infuse fleet drive steps/ --vehicle car7 --drive 12 --date 2026-03-01 -o 12.json"});
}

void declare_fleet_pool(CLI::App& app, FleetPoolArguments& arguments) {
  CLI::App* pool = app.add_subcommand(
      "pool", "combine the calibrations of each vehicle's drives, and say which vehicles drift");
  pool->add_option("ENTRY", arguments.entries, "entries of drives (infuse fleet drive)");
  pool->add_option("--list", arguments.list, "file with the path of an entry per line")
      ->type_name("FILE");
  pool->add_option("--rig", arguments.rigs,
                   "rig of a vehicle, with whose extrinsics the pooled ones are compared")
      ->type_name("VEHICLE=rig.toml")
      ->allow_extra_args(false);
  pool->add_option("--significance", arguments.options.significance,
                   "p-value below which calibrations are not of one pose (0.001)")
      ->type_name("P");
  pool->add_option("-o,--output", arguments.output,
                   "summary to write as JSON (default: standard output)")
      ->type_name("FILE.json");
  pool->add_option("--page", arguments.page, "page to write, one HTML file without other files")
      ->type_name("FILE.html");
  set_examples(*pool, {"infuse fleet pool car7/*.json --page fleet.html -o fleet.json",
                       "infuse fleet pool car7/*.json --rig car7=rig.toml | jq "
                       "'.vehicles[].cameras[].what'"});
}

}  // namespace

Command declare_fleet(CLI::App& infuse) {
  CLI::App* app = add_tool(infuse, *find_tool("fleet"));
  app->require_subcommand(1);
  const auto drive = std::make_shared<FleetDriveArguments>();
  const auto pool = std::make_shared<FleetPoolArguments>();
  declare_fleet_drive(*app, *drive);
  declare_fleet_pool(*app, *pool);
  return {app, [=] {
            return app->got_subcommand("drive") ? run_fleet_drive(*drive) : run_fleet_pool(*pool);
          }};
}

}  // namespace infuse::daemon
