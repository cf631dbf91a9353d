#include <boost/asio/io_context.hpp>
#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/version.hpp"
#include "daemon/config/config.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/report_images.hpp"
#include "daemon/owner/report_truth.hpp"
#include "daemon/pages/report_page.hpp"
#include "daemon/pipeline/replay.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "daemon/streetmap/street_map_file.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kReportProgram = "infuse report";

struct ReportArguments {
  std::string path, output, reports, config;
};

/// A file that is removed at the end.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::filesystem::path path) : path_(std::move(path)) {}
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

 private:
  std::filesystem::path path_;
};

Result<StreetMapFile> open_configured_map(const Config& config) {
  if (config.streetmap.map.empty()) return {};
  return open_street_map_file(config.resolve(config.streetmap.map));
}

/// Replays the drive as infused --replay does, without clients, and writes its reports to `file`.
Result<void> replay_to(const std::string& file, const std::string& drive, const Config& config,
                       const StreetMapFile& map) {
  auto setup = open_drive(drive, config.lidars, {});
  if (!setup) return tl::unexpected(setup.error());
  auto reports = ReportsFile::create(file);
  if (!reports) return tl::unexpected(reports.error());
  boost::asio::io_context io(1);
  Server server(io, config.socket, "", "");
  Replay replay(io, *std::move(setup),
                {std::nullopt,
                 {config.health, config.odometry, config.streetmap, {map, {}}, config.calibration}},
                server, &*reports, [&] { server.finish(std::chrono::milliseconds(0)); });
  replay.start();
  io.run();
  return reports->close();
}

/// Extent of what is drawn in the frame of the map.
Eigen::AlignedBox2d drawn_box(const Json& data) {
  Eigen::AlignedBox2d box;
  for (const char* key : {"map", "truth", "odom_on_truth"}) {
    if (!data.contains(key) || !data[key].is_object()) continue;
    for (size_t i = 0; i < data[key]["x"].size(); ++i) {
      box.extend(Eigen::Vector2d(data[key]["x"][i].get<double>(), data[key]["y"][i].get<double>()));
    }
  }
  return box;
}

/// Adds the true path and the errors against it, if the drive has a truth.
void add_truth(const recording::Drive& drive, const ReportData& reports, Json& data, Json& notes) {
  if (drive.description.truth_poses.empty()) return;
  const auto truth = recording::read_trajectory(drive.resolve(drive.description.truth_poses));
  if (!truth) {
    notes.push_back("The truth cannot be read: " + truth.error().message());
    return;
  }
  const Stamp start = *reports.start();
  data["truth"] = truth_json(*truth);
  data["true_moves"] = true_moves_json(drive.folder, start);
  const ComparedPath odom = compare_with_truth(reports.odom_poses(), *truth, true, start);
  data["odom_on_truth"] = odom.path;
  data["odom_errors"] = odom.errors;
  data["map_errors"] = compare_with_truth(reports.map_poses(), *truth, false, start).errors;
}

Result<Json> collect(const ReportArguments& arguments) {
  Config config;
  if (!arguments.config.empty()) {
    auto loaded = load_config(arguments.config);
    if (!loaded) return tl::unexpected(loaded.error());
    config = *std::move(loaded);
  }
  const auto map = open_configured_map(config);
  if (!map) return tl::unexpected(map.error());
  std::string file = arguments.reports;
  std::optional<TemporaryFile> made;
  if (file.empty()) {
    file = arguments.output + ".reports.jsonl";
    made.emplace(file);
    const auto replayed = replay_to(file, arguments.path, config, *map);
    if (!replayed) return tl::unexpected(replayed.error());
  }
  const auto reports = read_reports(file);
  if (!reports) return tl::unexpected(reports.error());
  Json data = reports->to_json();
  Json notes = Json::array();
  data["name"] = std::filesystem::path(arguments.path).filename().string();
  data["version"] = version();
  data["configuration"] = arguments.config;
  data["sweep"] = sweep_image_json(arguments.path, reports->moved_sweep().value_or(Stamp()));
  if (reports->start() && std::filesystem::is_directory(arguments.path)) {
    const auto drive = recording::Drive::open(arguments.path);
    if (!drive) return tl::unexpected(drive.error());
    if (!drive->description.name.empty()) data["name"] = drive->description.name;
    add_truth(*drive, *reports, data, notes);
    data["overlays"] = overlay_images(arguments.path, *reports, notes);
  }
  if (!reports->map_poses().empty()) {
    data["map_image"] = map_image(map->map, drawn_box(data));
  }
  data["notes"] = std::move(notes);
  return data;
}

int run_report(const ReportArguments& arguments) {
  const auto data = collect(arguments);
  if (!data) return print_error(kReportProgram, data.error(), kUnreadable);
  if (const auto written = text::write_text(arguments.output, make_report_page(*data)); !written) {
    return print_error(kReportProgram, written.error(), kFailure);
  }
  std::cout << arguments.output << " written, from " << (*data)["reports"] << " reports\n";
  return kDone;
}

}  // namespace

Command declare_report(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand(
      "report", "write a page with what a replay shows: track, calibration, health");
  const auto arguments = std::make_shared<ReportArguments>();
  app->add_option("DRIVE", arguments->path, "drive folder or capture")->required();
  app->add_option("-o,--output", arguments->output, "the page, one HTML file without other files")
      ->required()
      ->type_name("FILE");
  app->add_option("--reports", arguments->reports,
                  "reports of a replay (infused --reports); without it the drive is replayed")
      ->type_name("FILE");
  app->add_option("--config", arguments->config,
                  "configuration of the replay; its street map is drawn")
      ->type_name("FILE");
  set_examples(*app, {"infuse report drive/ -o report.html",
                      "infuse report drive/ --reports reports.jsonl --config infused.toml -o "
                      "report.html"});
  return {app, [arguments] { return run_report(*arguments); }};
}

}  // namespace infuse::daemon
