#include <iostream>
#include <string>

#include "tests/study/places/fit_study.hpp"
#include "tests/study/places/image_study.hpp"
#include "tests/study/places/other_houses.hpp"
#include "tests/study/places/place_study.hpp"
#include "tests/study/places/recognition_study.hpp"
#include "tests/study/places/upright.hpp"
#include "tests/study/resume.hpp"
#include "tests/study/study_commands.hpp"

namespace infuse::study {
namespace {

void add_visits(CLI::App& command, VisitOptions& options) {
  command.add_option("MAP", options.map, "map folder")->required();
  command.add_option("MAP_DRIVE", options.map_drive, "the drive it was made of")->required();
  command.add_option("DRIVE", options.drives, "visits, in the frame of that drive")->required();
}

void require_success(const std::string& error) {
  if (!error.empty()) throw CLI::ValidationError(error);
}

/// Adds the study of trials without an initial pose on a map of keyframes.
void add_places_command(CLI::App& app) {
  static PlaceStudyOptions options;
  CLI::App* command = app.add_subcommand(
      "places",
      "find the vehicle on a map of keyframes without an initial pose, all along simulated visits");
  add_visits(*command, options);
  command->add_option("--spacing", options.spacing, "m between trials")->capture_default_str();
  command->add_flag("--elsewhere", options.elsewhere, "the visits are off the map");
  command->callback([] { require_success(study_places(std::cout, options)); });
}

/// Adds the study of how well right and wrong places fit.
void add_fits_command(CLI::App& app) {
  static VisitOptions options;
  CLI::App* command = app.add_subcommand(
      "place-fits", "search a map all along simulated visits; print how well the places fit");
  add_visits(*command, options);
  command->callback([] { require_success(study_fits(std::cout, options)); });
}

/// Adds the study of the probability of places.
void add_odds_command(CLI::App& app) {
  static std::vector<std::string> files;
  static bool fit = false;
  CLI::App* command = app.add_subcommand(
      "place-odds", "compare the probability of places with how often they are right");
  command->add_option("FITS", files, "what place-fits printed")->required();
  command->add_flag("--fit", fit, "print the weights that suit these best");
  command->callback([] { require_success(study_place_odds(std::cout, files, fit)); });
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

/// Adds the study of streets whose houses are others.
void add_houses_command(CLI::App& app) {
  static std::string map, rows;
  static uint64_t seed = 7001;
  static int towns = 40;
  static bool quick = false;
  CLI::App* command = app.add_subcommand(
      "other-houses", "find the vehicle in the same streets in autumn, and with other houses");
  command->add_option("MAP", map, "fixtures/maps/altfeld.osm")->required();
  command->add_option("ROWS", rows, "CSV of the trials; towns in it are not tried again")
      ->required();
  command->add_option("--seed", seed, "of the first town")->capture_default_str();
  command->add_option("--towns", towns, "number of towns")
      ->capture_default_str()
      ->check(CLI::Range(1, 100'000));
  command->add_flag("--quick", quick, "three towns");
  command->callback([] {
    const auto trials = resume<HousesTrial>(
        rows, seed, quick ? 3 : towns, read_houses_trials, write_houses_header, write_houses_trial,
        [](uint64_t town) { return try_other_houses(map, town); });
    write_houses_table(std::cout, trials);
  });
}

/// Adds the study of how upright maps are.
void add_upright_command(CLI::App& app) {
  static std::string map, rows;
  static uint64_t seed = 8001;
  static int drives = 40;
  static bool quick = false;
  CLI::App* command = app.add_subcommand(
      "upright", "how upright maps of simulated drives are, with and without GNSS, inertial unit");
  command->add_option("MAP", map, "fixtures/maps/altfeld.osm")->required();
  command->add_option("ROWS", rows, "CSV of the trials; drives in it are not tried again")
      ->required();
  command->add_option("--seed", seed, "of the first drive")->capture_default_str();
  command->add_option("--drives", drives, "number of drives")
      ->capture_default_str()
      ->check(CLI::Range(1, 100'000));
  command->add_flag("--quick", quick, "six drives");
  command->callback([] {
    const auto trials = resume<UprightTrial>(rows, seed, quick ? 6 : drives, read_upright_trials,
                                             write_upright_header, write_upright_trial,
                                             [](uint64_t k) { return try_upright(map, k); });
    write_upright_table(std::cout, trials);
  });
}

}  // namespace

void add_places_commands(CLI::App& app) {
  add_places_command(app);
  add_fits_command(app);
  add_odds_command(app);
  add_recognition_command(app);
  add_images_command(app);
  add_houses_command(app);
  add_upright_command(app);
}

}  // namespace infuse::study
