#include "daemon/tools/map/map.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstdint>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/progress_line.hpp"
#include "daemon/mapping/g2o_file.hpp"
#include "daemon/mapping/map_finish.hpp"
#include "daemon/mapping/map_merge.hpp"
#include "daemon/playback/find_lidar.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "daemon/tools/map/map_drive.hpp"
#include "daemon/tools/map/map_export.hpp"
#include "daemon/tools/map/map_locate.hpp"
#include "drivers/text/text_file.hpp"
#include "fusion/mapping/chordal_initialisation.hpp"
#include "fusion/mapping/optimize.hpp"
#include "fusion/mapping/robust.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kMapProgram = "infuse map";

struct DriveArguments {
  std::string drive, output, lidar;
  bool no_closures = false, no_gnss = false, json = false;
};

struct MergeArguments {
  std::vector<std::string> maps;
  std::string output;
  bool no_gnss = false, json = false;
};

struct MapArguments {
  std::string graph, output;
  std::string cost = "information";
  std::string start = "edges";
  bool robust = false;
  bool json = false;
};

/// Sets the poses that the optimisation starts from; why it cannot, or an empty text.
template <int D>
std::string initialise(G2oGraph<D>& file, const std::string& start) {
  if (const size_t lost = mapping::first_unconnected(file.graph); lost < file.graph.poses.size()) {
    return fmt::format("no chain of edges joins pose {} to pose {}", file.ids[lost], file.ids[0]);
  }
  if (start == "file") return file.has_poses ? "" : "the file states no poses";
  if (start == "odometry") {
    mapping::compose_odometry(file.graph);
    return "";
  }
  return mapping::initialise_chordal(file.graph) ? "" : "the edges do not determine the poses";
}

/// An edge that was left out as false, by the ids of the file.
struct RejectedEdge {
  int64_t from = 0, to = 0;
  double chi2 = 0;
};

/// The graph at its optimum, and what was left out of it.
struct OptimizedFile {
  mapping::OptimizeResult result;
  std::string reason;  ///< empty if the poses are usable
  size_t closures = 0;
  std::vector<RejectedEdge> rejected;
};

template <int D>
OptimizedFile optimize(G2oGraph<D>& file, const mapping::OptimizeOptions& options, bool robust) {
  OptimizedFile out;
  const auto is_closure = [](const mapping::PoseEdge<D>& edge) { return edge.closure; };
  out.closures = static_cast<size_t>(std::ranges::count_if(file.graph.edges, is_closure));
  if (!robust) {
    out.result = mapping::PoseGraphSolver<D>(file.graph).optimize(file.graph, options);
    out.reason = out.result.reason;
    return out;
  }
  const mapping::RobustResult found = mapping::optimize_robustly(file.graph, options);
  out.result = found.optimized;
  out.reason = found.reason;
  std::vector<mapping::PoseEdge<D>> accepted;
  for (size_t e = 0; e < found.accepted.size(); ++e) {
    const mapping::PoseEdge<D>& edge = file.graph.edges[e];
    if (found.accepted[e] != 0) {
      accepted.push_back(edge);
    } else {
      out.rejected.push_back({file.ids[edge.from], file.ids[edge.to], found.chi2[e]});
    }
  }
  if (!found.accepted.empty()) file.graph.edges = std::move(accepted);
  return out;
}

nlohmann::ordered_json to_json(const OptimizedFile& optimized, size_t poses, size_t edges) {
  nlohmann::ordered_json rejected = nlohmann::ordered_json::array();
  for (const RejectedEdge& edge : optimized.rejected) {
    rejected.push_back({{"from", edge.from}, {"to", edge.to}, {"chi2", edge.chi2}});
  }
  return {{"poses", poses},
          {"edges", edges},
          {"closures", optimized.closures},
          {"rejected", std::move(rejected)},
          {"initial_cost", optimized.result.initial_cost},
          {"cost", optimized.result.cost},
          {"iterations", optimized.result.iterations},
          {"usable", optimized.reason.empty()},
          {"reason", optimized.reason}};
}

std::string to_text(const OptimizedFile& optimized, size_t poses, size_t edges,
                    const std::string& output) {
  std::string text = fmt::format(
      "{} poses, {} edges: cost {:.6g}, initially {:.6g}, {} steps, to {}\n", poses, edges,
      optimized.result.cost, optimized.result.initial_cost, optimized.result.iterations, output);
  if (!optimized.rejected.empty()) {
    text += fmt::format("{} of {} closures rejected:\n      from         to         chi2\n",
                        optimized.rejected.size(), optimized.closures);
  }
  for (const RejectedEdge& edge : optimized.rejected) {
    text += fmt::format("{:>10} {:>10} {:>12.6g}\n", edge.from, edge.to, edge.chi2);
  }
  return text + (optimized.reason.empty() ? "" : "not usable: " + optimized.reason + "\n");
}

template <int D>
int optimize_file(G2oGraph<D>& file, const MapArguments& arguments) {
  if (const std::string wrong = initialise(file, arguments.start); !wrong.empty()) {
    return print_error(kMapProgram, {wrong, arguments.graph, "--start edges"}, kUnreadable);
  }
  const OptimizedFile optimized = optimize(
      file,
      {.cost = arguments.cost == "chordal" ? mapping::Cost::kChordal : mapping::Cost::kInformation},
      arguments.robust);
  if (const auto written = text::write_text(arguments.output, format_g2o(file)); !written) {
    return print_error(kMapProgram, written.error(), kFailure);
  }
  const size_t poses = file.graph.poses.size(), edges = file.graph.edges.size();
  std::cout << (arguments.json ? json_text(to_json(optimized, poses, edges)) + "\n"
                               : to_text(optimized, poses, edges, arguments.output));
  return optimized.reason.empty() ? kDone : kFailure;
}

int run_map_optimize(const MapArguments& arguments) {
  auto graph = read_g2o(arguments.graph);
  if (!graph) return print_error(kMapProgram, graph.error(), kUnreadable);
  return std::visit([&](auto& file) { return optimize_file(file, arguments); }, *graph);
}

/// Makes the rest of a map of what it is made of, and prints its summary.
int finish_and_print(const MapFolder& folder, const MapSettings& settings, bool json) {
  const auto drive = read_map_drive(folder);
  if (!drive) return print_error(kMapProgram, drive.error(), kUnreadable);
  ProgressLine line;
  const auto summary =
      finish_map(folder, *drive, settings, [&](size_t done, size_t all, size_t closures) {
        line.show(static_cast<double>(done) / static_cast<double>(all),
                  fmt::format("{} of {} keyframes searched, {} closures", done, all, closures));
      });
  line.clear();
  if (!summary) return print_error(kMapProgram, summary.error(), kUnreadable);
  std::cout << (json ? json_text(to_json(*summary)) + "\n"
                     : folder.path().string() + ": " + to_text(*summary));
  return summary->usable() ? kDone : kFailure;
}

/// Makes a map of a drive, or goes on with one that was interrupted.
int run_map(const DriveArguments& arguments) {
  const MapSettings settings{.close_loops = !arguments.no_closures, .use_gnss = !arguments.no_gnss};
  auto setup = open_drive(arguments.drive, {}, {});
  if (!setup) return print_error(kMapProgram, setup.error(), kUnreadable);
  const auto lidar = find_lidar(*setup, arguments.lidar);
  if (!lidar) return print_error(kMapProgram, lidar.error(), kUsage);
  const MapFolder folder(arguments.output);
  if (const auto replayed = replay_to_map(folder, *setup, *lidar, settings); !replayed) {
    return print_error(kMapProgram, replayed.error(), kFailure);
  }
  for (const Error& note : setup->source.notes()) {
    std::cerr << kMapProgram << ": note: " << note.message() << "\n";
  }
  return finish_and_print(folder, settings, arguments.json);
}

/// Makes one map of several, or goes on with one that was interrupted.
int run_map_merge(const MergeArguments& arguments) {
  if (arguments.maps.size() < 2) {
    return print_error(kMapProgram, {"fewer than two maps are given", "", "see infuse map --help"},
                       kUsage);
  }
  const MapSettings settings{.use_gnss = !arguments.no_gnss};
  const MapFolder folder(arguments.output);
  const auto merged = merge_maps(folder, {arguments.maps.begin(), arguments.maps.end()}, settings);
  if (!merged) return print_error(kMapProgram, merged.error(), kUnreadable);
  return finish_and_print(folder, settings, arguments.json);
}

void declare_optimize(CLI::App& app, MapArguments& arguments) {
  CLI::App* optimize =
      app.add_subcommand("optimize", "find the poses of a graph that fit its edges best");
  optimize
      ->add_option("GRAPH", arguments.graph,
                   "pose graph in g2o's text format, in 2D (SE2) or 3D (SE3:QUAT), plain or "
                   "compressed (gzip, zstd)")
      ->required();
  optimize->add_option("-o,--output", arguments.output, "graph to write, with the poses found")
      ->required()
      ->type_name("FILE.g2o");
  optimize
      ->add_option("--cost", arguments.cost,
                   "what is minimised: the chi-squared of the full information (information), or "
                   "the chordal cost of certifiable solvers (chordal)")
      ->check(CLI::IsMember({"information", "chordal"}))
      ->type_name("COST");
  optimize
      ->add_option("--start", arguments.start,
                   "initial poses: from all edges by linear least squares (edges), composed along "
                   "the odometry (odometry), or those of the file (file)")
      ->check(CLI::IsMember({"edges", "odometry", "file"}))
      ->type_name("POSES");
  optimize->add_flag(
      "--robust", arguments.robust,
      "reject closures that contradict the odometry and each other; they are listed, "
      "and not in the graph that is written");
  optimize->add_flag("--json", arguments.json, "print the result as one JSON object");
  set_examples(*optimize, {"infuse map optimize graph.g2o.gz --robust -o optimised.g2o",
                           "infuse map optimize graph.g2o --start file -o optimised.g2o --json"});
}

void declare_map_export(CLI::App& app, MapExportArguments& arguments) {
  CLI::App* out = app.add_subcommand("export", "write a map as one cloud, trajectory or image");
  out->add_option("MAP", arguments.map, "a map folder")->required();
  out->add_option(
         "-o,--output", arguments.output,
         "cloud (.pcd, .ply, .las), trajectory of the keyframes (.tum), or view from above (.png, "
         "or .tif: GeoTIFF with the values themselves)")
      ->required()
      ->type_name("FILE");
  out->add_option(
         "--voxel", arguments.voxel,
         "m, one point per voxel of the cloud or side of a pixel (default: 0.25 of a cloud, "
         "0.2 of an image)")
      ->check(CLI::Range(0.05, 100.0))
      ->type_name("METRES");
  out->add_option("--show", arguments.show, "what a view from above shows: intensity or height")
      ->check(CLI::IsMember({"intensity", "height"}))
      ->type_name("WHAT");
  out->add_option("--drive", arguments.drive,
                  "number of the drive of a merged map, of a trajectory")
      ->check(CLI::PositiveNumber)
      ->type_name("N");
  out->add_flag("--without-moving", arguments.without_moving,
                "leave out what moved: points through which beams from other places passed");
  set_examples(*out, {"infuse map export map/ --without-moving -o map.ply",
                      "infuse map export map/ --show height -o map.tif"});
}

void declare_map_merge(CLI::App& app, MergeArguments& arguments) {
  CLI::App* merge = app.add_subcommand(
      "merge", "make one map of several: of other days, or of other parts of a town");
  merge->add_option("MAP", arguments.maps, "map folders that share streets, of one lidar mounting")
      ->required();
  merge
      ->add_option("-o,--output", arguments.output,
                   "map folder to write, or to go on with where a run was interrupted")
      ->required()
      ->type_name("MAP");
  merge->add_flag("--no-gnss", arguments.no_gnss, "do not use GNSS fixes");
  merge->add_flag("--json", arguments.json, "print the summary as one JSON object");
  set_examples(*merge, {"infuse map merge monday/ tuesday/ -o town/",
                        "infuse map merge town/ wednesday/ -o larger/ --json"});
}

void declare_map_locate(CLI::App& app, MapLocateArguments& arguments) {
  CLI::App* locate = app.add_subcommand(
      "locate", "find where a drive is on a map, without an initial pose, and track it there");
  locate->add_option("MAP", arguments.map, "a map folder")->required();
  locate
      ->add_option("DRIVE", arguments.drive,
                   "a drive folder, or a pcap or pcapng file, with a lidar")
      ->required();
  locate
      ->add_option("-o,--output", arguments.output,
                   "poses of the vehicle on the map to write, in TUM format: those at the ends of "
                   "the sweeps while it is tracked")
      ->type_name("FILE.tum");
  locate->add_option("--lidar", arguments.lidar, "lidar, if there are several")->type_name("NAME");
  locate->add_flag("--json", arguments.json, "print the summary as one JSON object");
  set_examples(*locate, {"infuse map locate map/ drive/ -o on_map.tum",
                         "infuse map locate map/ drive.pcap --json"});
}

}  // namespace

Command declare_map(CLI::App& infuse) {
  CLI::App* app = add_tool(infuse, *find_tool("map"));
  app->require_subcommand(0, 1);
  const auto graph = std::make_shared<MapArguments>();
  const auto drive = std::make_shared<DriveArguments>();
  const auto exported = std::make_shared<MapExportArguments>();
  const auto located = std::make_shared<MapLocateArguments>();
  const auto merged = std::make_shared<MergeArguments>();
  app->add_option("DRIVE", drive->drive, "a drive folder, or a pcap or pcapng file, with a lidar");
  app->add_option("-o,--output", drive->output,
                  "map folder to write, or to go on with where a run was interrupted")
      ->type_name("MAP");
  app->add_option("--lidar", drive->lidar, "lidar, if there are several")->type_name("NAME");
  app->add_flag("--no-closures", drive->no_closures, "do not seek loop closures");
  app->add_flag("--no-gnss", drive->no_gnss, "do not use GNSS fixes");
  app->add_flag("--json", drive->json, "print the summary as one JSON object");
  set_examples(*app, {"infuse map drive/ -o map/", "infuse map drive.pcap --no-gnss -o map/"});
  declare_optimize(*app, *graph);
  declare_map_export(*app, *exported);
  declare_map_locate(*app, *located);
  declare_map_merge(*app, *merged);
  return {app, [=] {
            if (app->got_subcommand("optimize")) return run_map_optimize(*graph);
            if (app->got_subcommand("export")) return run_map_export(*exported);
            if (app->got_subcommand("locate")) return run_map_locate(*located);
            if (app->got_subcommand("merge")) return run_map_merge(*merged);
            if (drive->drive.empty() || drive->output.empty()) {
              return print_error(kMapProgram,
                                 {drive->drive.empty() ? "no drive is given" : "no map is given",
                                  "", "usage: infuse map DRIVE -o MAP; see infuse map --help"},
                                 kUsage);
            }
            if (drive->drive.ends_with(".g2o")) {
              return run_map_optimize({.graph = drive->drive, .output = drive->output});
            }
            return run_map(*drive);
          }};
}

}  // namespace infuse::daemon
