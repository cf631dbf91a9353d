#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <memory>
#include <string>
#include <variant>

#include "daemon/command_line/arguments.hpp"
#include "daemon/commands/command.hpp"
#include "daemon/mapping/g2o_file.hpp"
#include "daemon/protocol/json.hpp"
#include "drivers/text/text_file.hpp"
#include "fusion/mapping/chordal_initialisation.hpp"
#include "fusion/mapping/optimize.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kMapProgram = "infuse map";

struct MapArguments {
  std::string graph, output;
  std::string cost = "information";
  std::string start = "edges";
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

template <int D>
int optimize_file(G2oGraph<D>& file, const MapArguments& arguments) {
  if (const std::string wrong = initialise(file, arguments.start); !wrong.empty()) {
    return print_error(kMapProgram, {wrong, arguments.graph, "--start edges"}, kUnreadable);
  }
  mapping::PoseGraphSolver<D> solver(file.graph);
  const mapping::OptimizeResult result = solver.optimize(
      file.graph, {.cost = arguments.cost == "chordal" ? mapping::Cost::kChordal
                                                       : mapping::Cost::kInformation});
  if (const auto written = text::write_text(arguments.output, format_g2o(file)); !written) {
    return print_error(kMapProgram, written.error(), kFailure);
  }
  if (arguments.json) {
    std::cout << json_text({{"poses", file.graph.poses.size()},
                            {"edges", file.graph.edges.size()},
                            {"initial_cost", result.initial_cost},
                            {"cost", result.cost},
                            {"iterations", result.iterations},
                            {"usable", result.usable()},
                            {"reason", result.reason}})
              << "\n";
  } else {
    std::cout << fmt::format("{} poses, {} edges: cost {:.6g}, initially {:.6g}, {} steps, to {}\n",
                             file.graph.poses.size(), file.graph.edges.size(), result.cost,
                             result.initial_cost, result.iterations, arguments.output);
    if (!result.usable()) std::cout << "not usable: " << result.reason << "\n";
  }
  return result.usable() ? kDone : kFailure;
}

int run(const MapArguments& arguments) {
  auto graph = read_g2o(arguments.graph);
  if (!graph) return print_error(kMapProgram, graph.error(), kUnreadable);
  return std::visit([&](auto& file) { return optimize_file(file, arguments); }, *graph);
}

}  // namespace

Command declare_map(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand("map", "optimise pose graphs");
  app->require_subcommand(1);
  CLI::App* optimize =
      app->add_subcommand("optimize", "find the poses of a graph that fit its edges best");
  const auto arguments = std::make_shared<MapArguments>();
  optimize
      ->add_option("GRAPH", arguments->graph,
                   "pose graph in g2o's text format, in 2D (SE2) or 3D (SE3:QUAT)")
      ->required();
  optimize->add_option("-o,--output", arguments->output, "graph to write, with the poses found")
      ->required()
      ->type_name("FILE.g2o");
  optimize
      ->add_option("--cost", arguments->cost,
                   "what is minimised: the chi-squared of the full information (information), or "
                   "the chordal cost of certifiable solvers (chordal)")
      ->check(CLI::IsMember({"information", "chordal"}))
      ->type_name("COST");
  optimize
      ->add_option("--start", arguments->start,
                   "initial poses: from all edges by linear least squares (edges), composed along "
                   "the odometry (odometry), or those of the file (file)")
      ->check(CLI::IsMember({"edges", "odometry", "file"}))
      ->type_name("POSES");
  optimize->add_flag("--json", arguments->json, "print the result as one JSON object");
  set_examples(*app, {"infuse map optimize graph.g2o -o optimised.g2o",
                      "infuse map optimize graph.g2o --cost chordal -o optimised.g2o --json"});
  set_examples(*optimize, {"infuse map optimize graph.g2o -o optimised.g2o",
                           "infuse map optimize graph.g2o --start file -o optimised.g2o --json"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
