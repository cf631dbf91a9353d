#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>

#include "fusion/registration/visual/k_means.hpp"
#include "tests/study/registration/alignment_table.hpp"
#include "tests/study/registration/covariance_study.hpp"
#include "tests/study/registration/global_guess_study.hpp"
#include "tests/study/registration/information_study.hpp"
#include "tests/study/registration/learn_codebook.hpp"
#include "tests/study/registration/recorded_scans.hpp"
#include "tests/study/study_commands.hpp"

namespace infuse::study {

void add_registration_commands(CLI::App& app) {
  static CodebookRecipe recipe;
  static std::string output;
  CLI::App* codebook = app.add_subcommand(
      "codebook", "learn the codebook of FPFH and SIFT from invented towns, P figs. 4.13 and 5.5");
  codebook->add_option("-o,--output", output, "file to write")->required();
  codebook->add_option("--drives", recipe.drives, "number of drives")->capture_default_str();
  codebook->add_option("--words", recipe.words, "number of codewords")->capture_default_str();
  codebook->callback([] {
    const auto features = training_features(recipe, {registration::ScanFeature::kFpfhSift});
    std::ofstream file(output);
    write_codebook(file, registration::learn_codebook(features.front(), recipe.words, 1), recipe);
    if (!file.flush()) throw CLI::FileError(output + ": cannot be written");
  });

  static InformationStudyOptions options;
  static std::string rows;
  static bool quick = false;
  CLI::App* information = app.add_subcommand(
      "information", "align simulated scans by mutual information, P figs. 4.18 to 4.21");
  information->add_option("ROWS", rows, "CSV of the pairs; drives in it are not rendered again")
      ->required();
  information->add_option("--drives", options.drives, "number of drives of 28 pairs each")
      ->capture_default_str();
  information
      ->add_option("--variants", options.variant_drives, "number of drives with all vocabularies")
      ->capture_default_str();
  information->add_flag("--quick", quick, "one drive without vocabularies");
  information->callback([] {
    if (quick) options.drives = 1, options.variant_drives = 0, options.training_drives = 2;
    run_information_study(rows, options);
    write_information_table(std::cout, rows);
    if (!quick) write_information_profile(std::cout << '\n', options.first_seed);
  });

  static SimulatedTableOptions simulated;
  static bool quick_table = false;
  static std::string drive, poses;
  CLI::App* table = app.add_subcommand(
      "alignment", "align scans by their distance, P table 4.1: of simulated drives, or of DRIVE");
  table->add_option("DRIVE", drive, "recorded drive with a camera");
  table->add_option("--poses", poses, "poses of its sweeps, T_first_k as KITTI's");
  table->add_option("--drives", simulated.drives, "number of simulated drives")
      ->capture_default_str();
  static size_t step = 3;
  table->add_option("--step", step, "sweeps of DRIVE from one target to the next; 1: all pairs")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  static size_t cycle = 0;
  table->add_option(
      "--cycles", cycle,
      "of DRIVE: errors around cycles of so many sweeps instead, without a reference");
  table->add_flag("--quick", quick_table, "one simulated drive, or two targets of DRIVE");
  table->callback([] {
    if (quick_table) simulated.drives = 1;
    if (drive.empty()) return simulated_alignment_table(simulated).write(std::cout);
    const auto recorded = read_recorded_scans(drive, poses);
    if (!recorded) throw std::runtime_error(recorded.error().message());
    if (cycle > 0)
      std::cout << cycle_errors(*recorded, cycle) << '\n';
    else
      recorded_alignment_table(*recorded, quick_table ? 30 : step).write(std::cout);
  });

  static int streets = 10;
  CLI::App* global = app.add_subcommand(
      "global", "global guess of scans at any heading: of simulated streets, or of DRIVE");
  global->add_option("DRIVE", drive, "recorded drive");
  global->add_option("--poses", poses, "poses of its sweeps, T_first_k as KITTI's");
  global->add_option("--drives", streets, "number of simulated streets, ten pairs each")
      ->capture_default_str();
  global->callback([] {
    if (drive.empty()) {
      std::cout << try_global_guess_simulated(1201, streets).text() << '\n';
      return;
    }
    const auto recorded = read_recorded_scans(drive, poses);
    if (!recorded) throw std::runtime_error(recorded.error().message());
    std::cout << try_global_guess(recorded->scans, 50, 1).text() << '\n';
  });

  static uint64_t first_seed = 1301;
  static int towns = 50;
  CLI::App* covariance = app.add_subcommand(
      "covariance", "errors of GICP in units of its covariance, neighbouring simulated sweeps");
  covariance->add_option("--seed", first_seed, "seed of the first drive")->capture_default_str();
  covariance->add_option("--drives", towns, "number of drives, ten pairs each")
      ->capture_default_str();
  covariance->callback([] { std::cout << normalised_errors(first_seed, towns).text() << '\n'; });
}

}  // namespace infuse::study
