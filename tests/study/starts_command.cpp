#include <iostream>
#include <string>

#include "tests/study/starts/start_study.hpp"
#include "tests/study/study_commands.hpp"

namespace infuse::study {

void add_starts_command(CLI::App& app) {
  static StartStudyRun run;
  CLI::App* command = app.add_subcommand(
      "starts", "find the vehicle on a street map from nothing, by odometry alone");
  command->add_option("FILES", run.files,
                      "pairs of a map (.osm) and a recorded trajectory on it; with --walks: maps");
  command->add_option("--drawn", run.drawn, "number of towns drawn at random, ten starts each");
  command->add_option("--walks", run.walks,
                      "number of random drives on the streets of each map, ten starts each");
  command->add_flag("--foreign", run.foreign,
                    "drive elsewhere: through another town, along the next file");
  command->add_option("--starts", run.starts, "number of starts on each recorded trajectory")
      ->capture_default_str();
  command->add_option("--length", run.options.length, "m that each start drives")
      ->capture_default_str();
  command->add_option("--seed", run.seed, "seed of the first")->capture_default_str();
  command->add_option("--marks", run.marks, "file for what every start knew, each 10 m");
  command->callback([] {
    const std::string wrong = run_start_study(std::cout, run);
    if (!wrong.empty()) throw CLI::ValidationError(wrong);
  });
}

}  // namespace infuse::study
