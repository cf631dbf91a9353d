#include <spdlog/fmt/fmt.h>

#include <deque>
#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/progress_line.hpp"
#include "daemon/commands/command.hpp"
#include "daemon/commands/play_lidar.hpp"
#include "daemon/commands/straight_sweeps.hpp"
#include "daemon/commands/sweep_picture.hpp"
#include "daemon/protocol/counters_json.hpp"
#include "drivers/camera/png_encoder.hpp"
#include "drivers/recording/sweep_export.hpp"
#include "drivers/recording/text_file.hpp"

namespace infuse::daemon {
namespace {

struct Arguments {
  std::string path;
  std::string output;
  std::string lidar;
  std::string model;
  std::optional<uint64_t> sweep;
  double cut_deg = LidarOptions().cut_azimuth_deg;
  bool straight = false;
  bool json = false;

  bool picture() const { return std::filesystem::path(output).extension() == ".png"; }
};

/// Writes the sweeps that were asked for, each to a file of its own.
class Writer {
 public:
  explicit Writer(const Arguments& arguments) : arguments_(arguments) {}

  /// As it was measured.
  void take(const Sweep& sweep) {
    if (!wanted(sweep)) return;
    note(sweep, recording::export_sweep(sweep, file_of(sweep.sequence), format()));
  }

  /// Corrected for motion.
  void take(const Sweep& sweep, const motion::StraightSweep& straight) {
    if (!wanted(sweep)) return;
    if (!straight.usable()) {
      ++bent_;
      bent_reason_ = straight.reason;
    }
    if (arguments_.picture()) {
      note(sweep, camera::encode_png(draw_sweep(sweep, straight)).and_then([&](const auto& png) {
        return recording::write_text(file_of(sweep.sequence),
                                     {reinterpret_cast<const char*>(png.data()), png.size()});
      }));
      return;
    }
    Sweep moved = sweep;
    moved.x = straight.x;
    moved.y = straight.y;
    moved.z = straight.z;
    note(sweep, recording::export_sweep(moved, file_of(sweep.sequence), format()));
  }

  /// Whether everything that was asked for is there, or cannot be.
  bool done() const { return error_ || (arguments_.sweep && files_ > 0); }

  void finish() { line_.clear(); }
  const std::optional<Error>& error() const { return error_; }
  uint64_t files() const { return files_; }
  uint64_t returns() const { return returns_; }
  uint64_t bent() const { return bent_; }
  const char* bent_reason() const { return bent_reason_; }

 private:
  bool wanted(const Sweep& sweep) const {
    return !error_ && (!arguments_.sweep || sweep.sequence == *arguments_.sweep);
  }

  recording::SweepFormat format() const { return *recording::sweep_format(arguments_.output); }

  void note(const Sweep& sweep, const Result<void>& written) {
    if (!written) error_ = written.error();
    ++files_;
    returns_ += sweep.size();
    line_.show(std::nullopt, fmt::format("{} sweeps written", files_));
  }

  /// "x.pcd" becomes "x-000017.pcd", unless only one sweep was asked for.
  std::filesystem::path file_of(uint64_t sequence) const {
    const std::filesystem::path path = arguments_.output;
    if (arguments_.sweep) return path;
    return path.parent_path() /
           fmt::format("{}-{:06}{}", path.stem().string(), sequence, path.extension().string());
  }

  const Arguments& arguments_;
  ProgressLine line_;
  uint64_t files_ = 0;
  uint64_t returns_ = 0;
  uint64_t bent_ = 0;             // sweeps that could not be corrected
  const char* bent_reason_ = "";  // why the last of them was not
  std::optional<Error> error_;
};

/// The lidar of that name, or the only one.
Result<size_t> find_lidar(const DriveSetup& setup, const std::string& name) {
  std::string names;
  for (size_t i = 0; i < setup.lidars.size(); ++i) {
    if (setup.lidars[i].name == name || (name.empty() && setup.lidars.size() == 1)) return i;
    names += (i == 0 ? "" : ", ") + setup.lidars[i].name;
  }
  if (setup.lidars.empty()) return fail("there is no lidar", setup.path.string());
  return fail(name.empty() ? "there are several lidars" : "there is no lidar '" + name + "'",
              setup.path.string(), "choose one with --lidar: " + names);
}

/// Reads the drive until the writer has what it wants.
void decode(DriveSetup& setup, size_t lidar, bool straight, Writer& writer) {
  StraightSweeps sweeps(setup.rig.lidars[lidar].T_vehicle_lidar, {});
  const auto on_sweep = [&](Sweep& sweep) { straight ? sweeps.take(sweep) : writer.take(sweep); };
  const auto on_sample = [&](const VehicleSample& sample) { sweeps.take(sample); };
  const auto on_straight = [&](const Sweep& sweep, const motion::StraightSweep& moved) {
    writer.take(sweep, moved);
  };
  play_lidar(setup, lidar, on_sweep, on_sample, [&](const recording::DriveEvent& event) {
    sweeps.release(event.stamp, on_straight);
    return !writer.done();
  });
  if (!writer.done()) sweeps.finish(on_straight);
}

int run(const Arguments& arguments) {
  constexpr const char* kProgram = "infuse decode";
  if (!arguments.picture() && !recording::sweep_format(arguments.output)) {
    return complain(kProgram,
                    {"the format of '" + arguments.output + "' is not known", "--output",
                     "end its name in .pcd, .ply, .csv, .bin or .png"},
                    kUsage);
  }
  LidarOptions options;
  options.cut_azimuth_deg = arguments.cut_deg;
  if (const auto wrong = options.invalid()) return complain(kProgram, {*wrong, "", ""}, kUsage);
  std::optional<velodyne::Model> model;
  if (!arguments.model.empty()) {
    model = velodyne::find_model(arguments.model);
    if (!model) {
      return complain(kProgram, {"unknown model '" + arguments.model + "'", "--model", ""}, kUsage);
    }
  }
  auto setup = open_drive(arguments.path, {}, model);
  if (!setup) return complain(kProgram, setup.error(), kUnreadable);
  const auto lidar = find_lidar(*setup, arguments.lidar);
  if (!lidar) return complain(kProgram, lidar.error(), kUsage);
  setup->lidars[*lidar].assembler.cut_azimuth = arguments.cut_deg;

  Writer writer(arguments);
  decode(*setup, *lidar, arguments.straight || arguments.picture(), writer);
  writer.finish();
  if (writer.error()) return complain(kProgram, *writer.error(), kNo);
  for (const Error& note : setup->source.notes()) {
    std::cerr << kProgram << ": note: " << note.message() << "\n";
  }
  if (writer.bent() > 0) {
    std::cerr << fmt::format("{}: note: {} sweep(s) not corrected for motion: {}\n", kProgram,
                             writer.bent(), writer.bent_reason());
  }
  if (writer.files() == 0) {
    return complain(kProgram, {"there is no such sweep", arguments.path, ""}, kNo);
  }
  if (arguments.json) {
    std::cout << Json{{"sweeps", writer.files()},
                      {"returns", writer.returns()},
                      {"uncompensated", writer.bent()}}
                     .dump()
              << "\n";
  } else {
    std::cout << fmt::format("{} sweeps of {}, {} returns, to {}\n", writer.files(),
                             setup->devices[*lidar].model, writer.returns(), arguments.output);
  }
  return kDone;
}

}  // namespace

Command declare_decode(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand(
      "decode", "sweeps to files: x.pcd becomes x-000000.pcd, x-000001.pcd, ...");
  const auto arguments = std::make_shared<Arguments>();
  app->add_option("PATH", arguments->path, "a pcap, or a drive folder")->required();
  app->add_option("-o,--output", arguments->output, "where to; the ending tells the format")
      ->required()
      ->type_name("FILE.{pcd,ply,csv,bin,png}");
  app->add_flag("--straight", arguments->straight,
                "corrected for the vehicle's motion, as of the sweep's end; a .png shows it from "
                "above, before (left) and after");
  app->add_option("--sweep", arguments->sweep, "only this one, counted from 0, to FILE itself")
      ->type_name("N");
  app->add_option("--lidar", arguments->lidar, "which, where there are several")->type_name("NAME");
  app->add_option("--model", arguments->model, "of the lidar, where it cannot be inferred")
      ->type_name("NAME");
  app->add_option("--cut", arguments->cut_deg,
                  "azimuth at which a sweep ends, clockwise from the front (180)")
      ->type_name("DEG");
  app->add_flag("--json", arguments->json, "the result as one JSON object");
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
