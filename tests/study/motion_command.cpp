#include <iostream>
#include <string>

#include "tests/study/motion/consistency_study.hpp"
#include "tests/study/motion/sources_study.hpp"
#include "tests/study/resume.hpp"
#include "tests/study/study_commands.hpp"

namespace infuse::study {
namespace {

struct SourcesArguments {
  uint64_t seed = 51'000;  // no other study draws from there
  int count = 40;
  bool quick = false, consistency = false;
  std::string output = "sources.csv";
};

void study_sources(SourcesArguments arguments) {
  if (arguments.quick) arguments.count = 4;
  if (arguments.consistency) {
    write_consistency(std::cout, arguments.seed, arguments.count);
    return;
  }
  const auto all = resume<SourcesTrial>(
      arguments.output, arguments.seed, arguments.count, read_sources_rows, write_sources_header,
      write_sources_row, [](uint64_t seed) { return std::vector{drive_by_sources(seed)}; });
  write_sources_summary(std::cout, all);
}

}  // namespace

void add_motion_command(CLI::App& app) {
  static SourcesArguments arguments;
  CLI::App* command = app.add_subcommand(
      "sources",
      "odometry by all sources against the best of them alone, on drives drawn at random");
  command->add_option("--seed", arguments.seed, "seed of the first drive")->capture_default_str();
  command->add_option("--drives", arguments.count, "number of drives")
      ->capture_default_str()
      ->check(CLI::Range(1, 100'000));
  command->add_flag("--quick", arguments.quick, "four drives");
  command->add_flag("--consistency", arguments.consistency,
                    "squared errors over their covariance instead, by combination of sources");
  command->add_option("-o,--output", arguments.output, "rows of all drives; goes on with them")
      ->capture_default_str();
  command->callback([] { study_sources(arguments); });
}

}  // namespace infuse::study
