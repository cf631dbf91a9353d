// infuse-study: lists the estimators of tests/study, runs one on a file, measures their accuracy.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/study/dependence/estimators.hpp"
#include "tests/study/dependence/gaussian_accuracy.hpp"
#include "tests/study/mapping/pose_graph_study.hpp"
#include "tests/study/months/month.hpp"
#ifdef INFUSE_SIMULATOR
#include "tests/study/places/image_study.hpp"
#include "tests/study/places/place_study.hpp"
#include "tests/study/places/recognition_study.hpp"
#include "tests/study/registration/alignment_table.hpp"
#include "tests/study/registration/covariance_study.hpp"
#include "tests/study/registration/global_guess_study.hpp"
#include "tests/study/registration/information_study.hpp"
#include "tests/study/registration/k_means.hpp"
#include "tests/study/registration/learn_codebook.hpp"
#include "tests/study/registration/recorded_scans.hpp"
#include "tests/study/rigs/compare_study.hpp"
#include "tests/study/rigs/far_study.hpp"
#include "tests/study/rigs/offset_study.hpp"
#include "tests/study/rigs/refine_study.hpp"
#include "tests/study/rigs/rig_study.hpp"
#include "tests/study/starts/start_study.hpp"
#endif

namespace infuse::study {
namespace {

/// Reads two columns of numbers separated by a comma or blanks, and scales each to zero mean and
/// unit variance. Throws CLI::ValidationError.
SamplePairs read_pairs(const std::string& path) {
  std::ifstream file(path);
  std::vector<double> values;
  std::string line;
  for (size_t number = 1; std::getline(file, line); ++number) {
    for (char& c : line) c = c == ',' ? ' ' : c;
    std::istringstream row(line);
    double x = 0, y = 0;
    if (!(row >> x >> y)) {
      if (number == 1) continue;  // header
      throw CLI::ValidationError(path + ":" + std::to_string(number), "not two numbers");
    }
    values.insert(values.end(), {x, y});
  }
  if (values.size() < 4) throw CLI::ValidationError(path, "fewer than two pairs");
  SamplePairs pairs =
      Eigen::Map<SamplePairs>(values.data(), 2, static_cast<Eigen::Index>(values.size() / 2));
  pairs.colwise() -= pairs.rowwise().mean().eval();
  const Eigen::Array2d sigma = pairs.array().square().rowwise().mean().sqrt();
  for (int side = 0; side < 2; ++side) {
    if (sigma[side] > 0) pairs.row(side) /= sigma[side];
  }
  return pairs;
}

const Estimator& find_estimator(const std::vector<Estimator>& estimators, const std::string& key) {
  for (const Estimator& estimator : estimators) {
    if (estimator.key == key) return estimator;
  }
  throw CLI::ValidationError("ESTIMATOR", "unknown estimator " + key + "; see infuse-study list");
}

void list(const std::vector<Estimator>& estimators) {
  for (const Estimator& estimator : estimators) {
    std::cout << estimator.key << std::string(std::max<size_t>(26 - estimator.key.size(), 1), ' ')
              << estimator.quantity << " by " << estimator.name << '\n';
  }
}

int run(const Estimator& estimator, const SamplePairs& pairs) {
  const Estimate estimate = estimator.estimate(pairs);
  if (estimate.usable()) {
    std::printf("%s %.6g\n", estimator.quantity.c_str(), estimate.value);
    return 0;
  }
  std::fprintf(stderr, "infuse-study: %s\n", estimate.reason);
  return 1;
}

int compare(const std::vector<Estimator>& estimators, const std::string& folder) {
  std::vector<AccuracyRow> rows;
  for (const Estimator& estimator : estimators) {
    std::cerr << estimator.quantity << ": " << estimator.name << '\n';
    rows.push_back(measure_accuracy(estimator));
  }
  if (folder.empty()) {
    write_table(std::cout, rows);
    return 0;
  }
  std::ofstream table(folder + "/accuracy.md"), plot(folder + "/accuracy.svg");
  write_table(table, rows);
  write_plot(plot, rows);
  if (table.flush() && plot.flush()) return 0;
  std::cerr << "infuse-study: cannot write to " << folder << '\n';
  return 3;
}

/// Adds the commands that optimise pose graphs.
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

#ifdef INFUSE_SIMULATOR
/// Adds the study of starts from nothing on a map of keyframes.
void add_places_command(CLI::App& app) {
  static PlaceStudyOptions options;
  CLI::App* command = app.add_subcommand(
      "places", "find the vehicle on a map of keyframes from nothing, all along simulated visits");
  command->add_option("MAP", options.map, "map folder")->required();
  command->add_option("MAP_DRIVE", options.map_drive, "the drive it was made of")->required();
  command->add_option("DRIVE", options.drives, "visits, in the frame of that drive")->required();
  command->add_option("--spacing", options.spacing, "m between starts")->capture_default_str();
  command->add_flag("--elsewhere", options.elsewhere, "the visits are off the map");
  command->callback([] {
    const std::string wrong = study_places(std::cout, options);
    if (!wrong.empty()) throw CLI::ValidationError(wrong);
  });
}

/// Adds the study of recognition across seasons.
void add_recognition_command(CLI::App& app) {
  static RecognitionOptions options;
  CLI::App* command = app.add_subcommand(
      "recognition", "recognise places across seasons by lidar and images, P figs. 5.8 to 5.10");
  command->add_option("MAP", options.map, "fixtures/maps/altfeld.osm")->required();
  command->add_option("--seed", options.world_seed, "of the town")->capture_default_str();
  command->add_option("--query-spacing", options.query_spacing, "m")->capture_default_str();
  command->callback([] { study_recognition(std::cout, options); });
}

/// Adds the study of sequences of images across seasons.
void add_images_command(CLI::App& app) {
  static ImageStudyOptions options;
  CLI::App* command =
      app.add_subcommand("image-places", "find images across seasons by sequences, P 6.2.3");
  command->add_option("MAP", options.map, "fixtures/maps/altfeld.osm")->required();
  command->add_option("--seed", options.tested, "of the town")->capture_default_str();
  command->callback([] { study_images(std::cout, options); });
}

/// Adds the study of starts from nothing on a street map.
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

/// Adds the commands that render scenes.
void add_registration_commands(CLI::App& app) {
  static CodebookRecipe recipe;
  static std::string output;
  CLI::App* codebook = app.add_subcommand(
      "codebook", "learn the codebook of FPFH and SIFT from drives through invented towns");
  codebook->add_option("-o,--output", output, "file to write")->required();
  codebook->add_option("--drives", recipe.drives, "number of drives")->capture_default_str();
  codebook->add_option("--words", recipe.words, "number of codewords")->capture_default_str();
  codebook->callback([] {
    const auto features = training_features(recipe, {registration::ScanFeature::kFpfhSift});
    std::ofstream file(output);
    write_codebook(file, learn_codebook(features.front(), recipe.words, 1), recipe);
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
  table->add_flag("--quick", quick_table, "one simulated drive, or one base scan of DRIVE");
  table->callback([] {
    if (quick_table) simulated.drives = 1;
    if (drive.empty()) return simulated_alignment_table(simulated).write(std::cout);
    const auto recorded = read_recorded_scans(drive, poses);
    if (!recorded) throw std::runtime_error(recorded.error().message());
    recorded_alignment_table(*recorded, quick_table ? 1 : 7).write(std::cout);
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

  add_places_command(app);
  add_recognition_command(app);
  add_images_command(app);

  add_starts_command(app);

  static uint64_t first_seed = 1301;
  static int towns = 50;
  CLI::App* covariance = app.add_subcommand(
      "covariance", "errors of GICP in units of its covariance, neighbouring simulated sweeps");
  covariance->add_option("--seed", first_seed, "seed of the first drive")->capture_default_str();
  covariance->add_option("--drives", towns, "number of drives, ten pairs each")
      ->capture_default_str();
  covariance->callback([] { std::cout << normalised_errors(first_seed, towns).text() << '\n'; });
}
#endif

struct RigsArguments {
  uint64_t seed = 20'000;  // no other study draws from there
  int count = 20;
  int scenes = 40;
  bool cells = false, any_heading = false, details = false;
  std::string output = "rigs.csv";
};

/// Rows of all trials go to the file, the summary to standard output. Rigs that the file has are
/// not tried again.
int study_rigs([[maybe_unused]] const RigsArguments& arguments) {
#ifdef INFUSE_SIMULATOR
  std::ifstream before(arguments.output);
  std::vector<RigTrial> all = read_rows(before);
  std::ofstream rows(arguments.output, std::ios::app);
  if (!rows) {
    std::cerr << "infuse-study: cannot write " << arguments.output << '\n';
    return 2;
  }
  rows << '\n';  // ends a row whose writing was interrupted
  write_header(rows);
  const RigRecordingOptions recorded = arguments.cells
                                           ? RigRecordingOptions{.diverse = 40, .neighbours = 40}
                                           : RigRecordingOptions{.diverse = 10, .neighbours = 0};
  for (uint64_t seed = arguments.seed;
       seed < arguments.seed + static_cast<uint64_t>(arguments.count); ++seed) {
    if (std::any_of(all.begin(), all.end(), [&](const RigTrial& t) { return t.seed == seed; })) {
      continue;
    }
    const auto recording = record_random_rig(seed, recorded);
    if (!recording) {
      std::cerr << "infuse-study: rig " << seed << ": " << recording.error().message() << '\n';
      continue;
    }
    const TrialSet set = arguments.cells ? TrialSet::kCells : TrialSet::kTrust;
    std::ostream* details = arguments.details ? &std::cout : nullptr;
    for (const RigTrial& trial : try_rig(*recording, seed, set, details)) {
      write_row(rows, trial);
      all.push_back(trial);
    }
    rows << std::flush;
  }
  write_summary(std::cout, all);
  return 0;
#else
  std::cerr << "infuse-study: built without the simulator\n";
  return 3;
#endif
}

/// How often the better of two extrinsics is named, over rigs drawn at random.
int study_comparison([[maybe_unused]] const RigsArguments& arguments) {
#ifdef INFUSE_SIMULATOR
  CompareCounts counts;
  for (uint64_t seed = arguments.seed;
       seed < arguments.seed + static_cast<uint64_t>(arguments.count); ++seed) {
    const auto recording = record_random_rig(seed, {.diverse = 20, .neighbours = 0});
    if (recording) compare_on(*recording, seed, counts);
  }
  std::cout << counts.text();
  return 0;
#else
  std::cerr << "infuse-study: built without the simulator\n";
  return 3;
#endif
}

/// Refines wrong intrinsics of rigs drawn at random.
int study_refinement([[maybe_unused]] const RigsArguments& arguments) {
#ifdef INFUSE_SIMULATOR
  RefineCounts counts;
  std::cout << "seed,lidar,width,refined,usable,focal_percent,cx_px,cy_px,k1,sigma_focal_percent,"
               "sigma_cx,sigma_cy,sigma_k1,rotation_deg,translation_cm,cpu_s,reason\n";
  for (uint64_t seed = arguments.seed;
       seed < arguments.seed + static_cast<uint64_t>(arguments.count); ++seed) {
    const auto recording = record_random_rig(seed, {.diverse = arguments.scenes, .neighbours = 0});
    if (recording) refine_on(*recording, seed, std::cout, counts);
    std::cout << std::flush;
  }
  std::cout << counts.refined << " of " << counts.trials << " refined, " << counts.usable
            << " usable; of the refined ones " << counts.within << " within 0.5 %, 2 px, 0.01; "
            << counts.inside << " inside 95 %\n";
  return 0;
#else
  std::cerr << "infuse-study: built without the simulator\n";
  return 3;
#endif
}

/// Starts far from the truth.
int study_far_starts([[maybe_unused]] const RigsArguments& arguments) {
#ifdef INFUSE_SIMULATOR
  FarCounts counts;
  std::cout << "seed,lidar,width,heading_deg,converged,usable,rotation_deg,translation_cm,cpu_s,"
               "reason\n";
  const int scenes = arguments.any_heading ? 20 : 6;
  for (uint64_t seed = arguments.seed;
       seed < arguments.seed + static_cast<uint64_t>(arguments.count); ++seed) {
    const auto recording = record_random_rig(seed, {.diverse = scenes, .neighbours = 0});
    if (!recording) continue;
    start_far(*recording, seed,
              arguments.any_heading ? FarStart::kAnyHeading : FarStart::kTenDegrees, std::cout,
              counts);
    std::cout << std::flush;
  }
  std::cout << counts.converged << " of " << counts.trials << " converged, " << counts.usable
            << " usable, of these " << counts.wrong << " elsewhere\n";
  return 0;
#else
  std::cerr << "infuse-study: built without the simulator\n";
  return 3;
#endif
}

#ifdef INFUSE_SIMULATOR
/// Adds the study of a recorded drive's stated extrinsics.
void add_offset_command(CLI::App& app) {
  static std::string drive, camera;
  CLI::App* command = app.add_subcommand(
      "offset", "score a drive's stated extrinsics and ours on images that were held out");
  command->add_option("DRIVE", drive, "recorded drive")->required();
  command->add_option("--camera", camera, "camera, if there are several");
  command->callback([] {
    if (const auto done = study_offset(std::cout, drive, camera); !done) {
      throw std::runtime_error(done.error().message());
    }
  });
}
#endif

}  // namespace
}  // namespace infuse::study

int main(int argc, char** argv) {
  using namespace infuse::study;
  CLI::App app("Runs the estimators that are only compared, not used by the product.");
  app.require_subcommand(1);
  app.add_subcommand("list", "list the estimators and the quantities that they estimate");
  std::string key, file, folder;
  CLI::App* run_command = app.add_subcommand("run", "run one estimator on pairs of numbers");
  run_command->add_option("ESTIMATOR", key, "key of the estimator, see list")->required();
  run_command
      ->add_option("FILE", file,
                   "two columns of numbers; each is scaled to zero mean and unit variance")
      ->required()
      ->check(CLI::ExistingFile);
  CLI::App* accuracy_command = app.add_subcommand(
      "accuracy", "measure bias and standard deviation on the bivariate Gaussian");
  accuracy_command->add_option("ESTIMATOR", key, "key of the estimator (default: all)");
  accuracy_command
      ->add_option("-o,--output", folder, "write accuracy.md and accuracy.svg to this folder")
      ->check(CLI::ExistingDirectory);
  add_mapping_commands(app);
  MonthOptions month;
  CLI::App* month_command =
      app.add_subcommand("months", "days of the live daemon with drawn faults, in drive time");
  month_command->add_option("--days", month.days, "days (30)");
  month_command->add_option("--seed", month.seed, "seed of the faults (1)");
#ifdef INFUSE_SIMULATOR
  add_registration_commands(app);
  add_offset_command(app);
#endif
  RigsArguments rigs;
  CLI::App* rigs_command = app.add_subcommand(
      "rigs", "calibrate rigs and worlds drawn at random, rightly and with faults");
  rigs_command->add_option("--seed", rigs.seed, "seed of the first rig (20000)");
  rigs_command->add_option("--count", rigs.count, "number of rigs (20)");
  rigs_command->add_flag("--cells", rigs.cells,
                         "right ones of 3 to 40 scenes, diverse and neighbouring, instead");
  rigs_command->add_flag("--details", rigs.details, "print what each stated covariance is made of");
  rigs_command->add_option("-o,--output", rigs.output,
                           "rows of all trials; an interrupted study goes on from it (rigs.csv)");
  RigsArguments compared;
  CLI::App* compare_command = app.add_subcommand(
      "compare", "compare right extrinsics of rigs drawn at random with wrong ones");
  compare_command->add_option("--seed", compared.seed, "seed of the first rig (20000)");
  compare_command->add_option("--count", compared.count, "number of rigs (20)");
  RigsArguments refined;
  CLI::App* refine_command =
      app.add_subcommand("refine", "refine wrong intrinsics of rigs drawn at random");
  refine_command->add_option("--seed", refined.seed, "seed of the first rig (20000)");
  refine_command->add_option("--count", refined.count, "number of rigs (20)");
  refine_command->add_option("--scenes", refined.scenes, "number of scenes of each (40)");
  RigsArguments far;
  CLI::App* far_command = app.add_subcommand(
      "far", "calibrate rigs drawn at random from 10 degrees off, with 6 scenes");
  far_command->add_option("--seed", far.seed, "seed of the first rig (20000)");
  far_command->add_option("--count", far.count, "number of rigs (20)");
  far_command->add_flag("--any-heading", far.any_heading,
                        "from any heading and 30 cm off, with 20 scenes, instead");
  try {
    app.parse(argc, argv);
    if (compare_command->parsed()) return study_comparison(compared);
    if (refine_command->parsed()) return study_refinement(refined);
    if (far_command->parsed()) return study_far_starts(far);
    if (rigs_command->parsed()) return study_rigs(rigs);
    if (month_command->parsed()) return simulate_month(month).print(std::cout) ? 0 : 1;
    const std::vector<Estimator> estimators = make_estimators();
    if (run_command->parsed()) return run(find_estimator(estimators, key), read_pairs(file));
    if (accuracy_command->parsed()) {
      return key.empty() ? compare(estimators, folder)
                         : compare({find_estimator(estimators, key)}, folder);
    }
    if (app.got_subcommand("list")) list(estimators);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : 2;
  } catch (const std::runtime_error& error) {
    std::cerr << "infuse-study: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
