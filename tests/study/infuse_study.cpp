// infuse-study: lists the estimators of tests/study, runs one on a file, measures their accuracy;
// runs the other studies.

#include <algorithm>
#include <iostream>
#include <stdexcept>
#include <string>

#include "tests/study/study_commands.hpp"

namespace {

/// Prints each command with the tables and figures of the theses that it makes (P, I), if any.
void list_commands(const CLI::App& app) {
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    const std::string& name = command->get_name();
    std::cout << name << std::string(16 - std::min<size_t>(15, name.size()), ' ')
              << command->get_description() << '\n';
  }
}

}  // namespace

int main(int argc, char** argv) {
  using namespace infuse::study;
  CLI::App app("Runs the estimators that are only compared, not used by the product.");
  app.require_subcommand(1);
  app.add_flag_callback(
      "--list",
      [&app] {
        list_commands(app);
        throw CLI::Success();
      },
      "list the commands, and which table or figure of which thesis each makes");
  int status = 0;
  add_estimator_commands(app, status);
  add_mapping_commands(app);
  add_motion_command(app);
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
