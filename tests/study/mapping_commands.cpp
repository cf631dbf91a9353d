#include <iostream>
#include <string>
#include <vector>

#include "tests/study/mapping/pose_graph_study.hpp"
#include "tests/study/study_commands.hpp"

namespace infuse::study {

void add_mapping_commands(CLI::App& app) {
  static std::vector<std::string> graphs;
  static int seeds = 10;
  CLI::App* optimize = app.add_subcommand(
      "pose-graphs", "optimise pose graphs with both costs, from two initial guesses");
  optimize->add_option("FILE", graphs, "g2o files; .xz is decompressed")->required();
  optimize->callback([] { optimize_graphs(std::cout, graphs); });
  CLI::App* reject = app.add_subcommand(
      "false-closures", "add false closures to pose graphs and count those that are rejected");
  reject->add_option("FILE", graphs, "g2o files; .xz is decompressed")->required();
  reject->add_option("--seeds", seeds, "number of seeds")->capture_default_str();
  reject->callback([] { reject_false_closures(std::cout, graphs, seeds); });
}

}  // namespace infuse::study
