#include "daemon/tools/export/export.hpp"

#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/tools/export/mcap_export.hpp"

namespace infuse::daemon {
namespace {

struct ExportArguments {
  std::string drive;
  std::string output;
  std::string reports;
  bool deskew = false;
  bool recover = false;
  bool json = false;
};

int run_mcap(const ExportArguments& arguments) {
  constexpr const char* kProgram = "infuse export mcap";
  if (arguments.recover && (arguments.deskew || !arguments.reports.empty())) {
    return print_error(
        kProgram,
        {"--recover copies a file as it is", "--recover", "leave out --deskew and --reports"},
        kUsage);
  }
  const auto written = arguments.recover ? recover_mcap(arguments.drive, arguments.output)
                                         : export_mcap(arguments.drive, arguments.output,
                                                       {arguments.reports, arguments.deskew});
  if (!written) return print_error(kProgram, written.error(), kUnreadable);
  for (const Error& note : written->notes)
    std::cerr << kProgram << ": note: " << note.message() << "\n";
  if (arguments.json) {
    Json json = {{"file", arguments.output}, {"topics", Json::object()}};
    for (const auto& [topic, count] : written->messages) json["topics"][topic] = count;
    std::cout << json_text(json) << "\n";
    return kDone;
  }
  size_t total = 0;
  for (const auto& [topic, count] : written->messages) total += count;
  std::cout << fmt::format("{}: {} messages on {} topics\n", arguments.output, total,
                           written->messages.size());
  for (const auto& [topic, count] : written->messages)
    std::cout << fmt::format("  {:<40} {:>8}\n", topic, count);
  return kDone;
}

}  // namespace

Command declare_export(CLI::App& infuse) {
  CLI::App* app = add_tool(infuse, *find_tool("export"));
  app->require_subcommand(1);
  CLI::App* mcap = app->add_subcommand("mcap", "ROS 2 messages, for ros2 bag play and Foxglove");
  const auto arguments = std::make_shared<ExportArguments>();
  mcap->add_option("DRIVE", arguments->drive, "a drive folder, or a pcap or pcapng file")
      ->required();
  mcap->add_option("-o,--output", arguments->output, "file to write")
      ->required()
      ->type_name("FILE.mcap");
  mcap->add_option("--reports", arguments->reports,
                   "also write the poses and alerts of these reports, of a replay")
      ->type_name("FILE");
  mcap->add_flag("--deskew", arguments->deskew, "also write deskewed clouds, on .../points");
  mcap->add_flag(
      "--recover", arguments->recover,
      "DRIVE is an MCAP file that is truncated or damaged: write what can be read to FILE, "
      "with an index");
  mcap->add_flag("--json", arguments->json, "print the result as one JSON object");
  set_examples(*app, {"infuse export mcap drive/ -o drive.mcap",
                      "infuse export mcap --recover cut.mcap -o whole.mcap"});
  set_examples(*mcap, {"infuse export mcap drive/ --deskew --reports reports.jsonl -o drive.mcap",
                       "infuse export mcap --recover cut.mcap -o whole.mcap"});
  return {app, [arguments] { return run_mcap(*arguments); }};
}

}  // namespace infuse::daemon
