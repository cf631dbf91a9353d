// infuse-study: lists the estimators of tests/study, runs one on a file, measures their accuracy;
// runs the other studies.

#include <iostream>
#include <stdexcept>

#include "tests/study/study_commands.hpp"

int main(int argc, char** argv) {
  using namespace infuse::study;
  CLI::App app("Runs the estimators that are only compared, not used by the product.");
  app.require_subcommand(1);
  int status = 0;
  add_estimator_commands(app, status);
  add_mapping_commands(app);
  add_month_command(app, status);
#ifdef INFUSE_SIMULATOR
  add_registration_commands(app);
  add_places_commands(app);
  add_starts_command(app);
#endif
  add_rigs_commands(app, status);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : 2;
  } catch (const std::runtime_error& error) {
    std::cerr << "infuse-study: " << error.what() << '\n';
    return 1;
  }
  return status;
}
