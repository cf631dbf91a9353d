#include <spdlog/fmt/fmt.h>

#include <deque>
#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/lidar_problems.hpp"
#include "daemon/command_line/progress_line.hpp"
#include "daemon/drawing/sweep_image.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/pipeline/odometry_plan.hpp"
#include "daemon/playback/deskewed_sweeps.hpp"
#include "daemon/playback/find_lidar.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/camera/png_encoder.hpp"
#include "drivers/recording/sweep_export.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

struct DecodeArguments {
  std::string path;
  std::string output;
  std::string lidar;
  std::string model;
  std::string calibration;
  std::optional<uint64_t> sweep;
  double cut_deg = LidarOptions().cut_azimuth_deg;
  bool deskew = false;
  bool single_origin = false;
  bool json = false;

  bool writes_image() const { return std::filesystem::path(output).extension() == ".png"; }
};

/// Writes the requested sweeps, each to a file of its own.
class Writer {
 public:
  explicit Writer(const DecodeArguments& arguments) : arguments_(arguments) {}

  /// Writes a sweep as measured.
  void write(const Sweep& sweep) {
    if (!is_selected(sweep)) return;
    count_written(sweep, recording::export_sweep(sweep, file_path(sweep.sequence), format()));
  }

  /// Writes a deskewed sweep.
  void write_deskewed(const Sweep& sweep, const motion::DeskewedSweep& deskewed) {
    if (!is_selected(sweep)) return;
    if (!deskewed.usable()) {
      ++not_deskewed_;
      deskew_reason_ = deskewed.reason;
    }
    if (arguments_.writes_image()) {
      count_written(
          sweep, camera::encode_png(draw_sweep(sweep, deskewed)).and_then([&](const auto& png) {
            return text::write_text(file_path(sweep.sequence),
                                    {reinterpret_cast<const char*>(png.data()), png.size()});
          }));
      return;
    }
    Sweep moved = sweep;
    moved.x = deskewed.x;
    moved.y = deskewed.y;
    moved.z = deskewed.z;
    count_written(sweep, recording::export_sweep(moved, file_path(sweep.sequence), format()));
  }

  /// True if everything requested has been written, or writing has failed.
  bool done() const { return error_ || (arguments_.sweep && files_ > 0); }

  void finish() { line_.clear(); }
  const std::optional<Error>& error() const { return error_; }
  uint64_t files() const { return files_; }
  uint64_t returns() const { return returns_; }
  uint64_t not_deskewed() const { return not_deskewed_; }
  const char* deskew_reason() const { return deskew_reason_; }

 private:
  bool is_selected(const Sweep& sweep) const {
    return !error_ && (!arguments_.sweep || sweep.sequence == *arguments_.sweep);
  }

  recording::SweepFormat format() const {
    return *recording::detect_sweep_format(arguments_.output);
  }

  void count_written(const Sweep& sweep, const Result<void>& written) {
    if (!written) error_ = written.error();
    ++files_;
    returns_ += sweep.size();
    line_.show(std::nullopt, fmt::format("{} sweeps written", files_));
  }

  /// "x.pcd" becomes "x-000017.pcd", unless a single sweep was requested.
  std::filesystem::path file_path(uint64_t sequence) const {
    std::filesystem::path path = arguments_.output;
    if (arguments_.sweep) return path;
    return path.parent_path() /
           fmt::format("{}-{:06}{}", path.stem().string(), sequence, path.extension().string());
  }

  const DecodeArguments& arguments_;
  ProgressLine line_;
  uint64_t files_ = 0;
  uint64_t returns_ = 0;
  uint64_t not_deskewed_ = 0;       // sweeps that could not be deskewed
  const char* deskew_reason_ = "";  // why the last of these was not
  std::optional<Error> error_;
};

/// Reads the drive until the writer is done; returns the lidar's counters.
LidarCounters decode(SensorSetup& setup, size_t lidar, bool deskew, Writer& writer) {
  DeskewedSweeps sweeps(plan_odometry({}, setup, lidar), setup.rig.lidars[lidar].T_vehicle_lidar);
  const auto on_sweep = [&](Sweep& sweep) {
    deskew ? sweeps.add_sweep(sweep) : writer.write(sweep);
  };
  const auto on_sample = [&](const VehicleSample& sample) { sweeps.add_sample(sample); };
  const auto on_deskewed = [&](const Sweep& sweep, const motion::DeskewedSweep& moved) {
    writer.write_deskewed(sweep, moved);
  };
  const LidarCounters counters =
      play_lidar(setup, lidar, on_sweep, on_sample, [&](const recording::DriveEvent& event) {
        sweeps.process_due(event.stamp, on_deskewed);
        return !writer.done();
      });
  if (!writer.done()) sweeps.finish(on_deskewed);
  return counters;
}

int run(const DecodeArguments& arguments) {
  constexpr const char* kProgram = "infuse decode";
  if (!arguments.writes_image() && !recording::detect_sweep_format(arguments.output)) {
    return print_error(kProgram,
                       {"unknown format of '" + arguments.output + "'", "--output",
                        "use the extension .pcd, .ply, .csv, .bin or .png"},
                       kUsage);
  }
  LidarOptions options;
  options.cut_azimuth_deg = arguments.cut_deg;
  if (const auto wrong = options.invalid()) return print_error(kProgram, {*wrong, "", ""}, kUsage);
  const auto model = requested_model(arguments.model);
  if (!model) return print_error(kProgram, model.error(), kUsage);
  auto setup = open_drive(arguments.path, {}, {*model, arguments.calibration});
  if (!setup) return print_error(kProgram, setup.error(), kUnreadable);
  const auto lidar = find_lidar(*setup, arguments.lidar);
  if (!lidar) return print_error(kProgram, lidar.error(), kUsage);
  lidar::DecoderOptions& decoder = setup->lidars[*lidar].decoder;
  decoder.cut_azimuth = options.cut_azimuth_deg;
  decoder.single_origin = arguments.single_origin;

  Writer writer(arguments);
  const LidarCounters counters =
      decode(*setup, *lidar, arguments.deskew || arguments.writes_image(), writer);
  writer.finish();
  if (writer.error()) return print_error(kProgram, *writer.error(), kFailure);
  for (const Error& note : setup->source.notes()) {
    std::cerr << kProgram << ": note: " << note.message() << "\n";
  }
  for (const LidarProblem& problem : find_problems(setup->lidars[*lidar].device, counters)) {
    std::cerr << kProgram << ": note: " << problem.what << "\n";
  }
  if (writer.not_deskewed() > 0) {
    std::cerr << fmt::format("{}: note: {} sweep(s) not deskewed: {}\n", kProgram,
                             writer.not_deskewed(), writer.deskew_reason());
  }
  if (writer.files() == 0) {
    return print_error(kProgram, {"no such sweep", arguments.path, ""}, kFailure);
  }
  if (arguments.json) {
    std::cout << json_text({{"sweeps", writer.files()},
                            {"returns", writer.returns()},
                            {"not_deskewed", writer.not_deskewed()}})
              << "\n";
  } else {
    std::cout << fmt::format("{} sweeps of {}, {} returns, to {}\n", writer.files(),
                             setup->lidars[*lidar].device.model, writer.returns(),
                             arguments.output);
  }
  return kDone;
}

}  // namespace

Command declare_decode(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand(
      "decode", "write sweeps to files: x.pcd becomes x-000000.pcd, x-000001.pcd, ...");
  const auto arguments = std::make_shared<DecodeArguments>();
  app->add_option(
         "PATH", arguments->path,
         "a pcap or pcapng file, or a drive folder; the first part, a pattern or the folder of a "
         "split capture")
      ->required();
  app->add_option("-o,--output", arguments->output,
                  "file to write; its extension selects the format")
      ->required()
      ->type_name("FILE.{pcd,ply,csv,bin,png}");
  app->add_flag(
      "--deskew", arguments->deskew,
      "deskew to the end of the sweep; a .png always shows both, from above: before (left) "
      "and after");
  app->add_option("--sweep", arguments->sweep, "only this sweep, counted from 0, to FILE itself")
      ->type_name("N");
  app->add_option("--lidar", arguments->lidar, "lidar, if there are several")->type_name("NAME");
  app->add_option("--model", arguments->model, "model of the lidar, if it cannot be inferred")
      ->type_name("NAME");
  app->add_option("--calibration", arguments->calibration,
                  "db.xml of an HDL-64E, angle file of a Hesai")
      ->type_name("FILE");
  app->add_flag("--single-origin", arguments->single_origin,
                "all beams from one origin, as ROS drivers decode them; heights differ by up to "
                "27 mm");
  app->add_option("--cut", arguments->cut_deg,
                  "azimuth at which a sweep ends, clockwise from the front (180)")
      ->type_name("DEG");
  app->add_flag("--json", arguments->json, "print the result as one JSON object");
  set_examples(*app, {"infuse decode drive.pcap -o cloud.pcd",
                      "infuse decode drive/ --sweep 121 --deskew -o sweep.png"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
