#include <iostream>

#include "tests/study/months/month.hpp"
#include "tests/study/study_commands.hpp"

namespace infuse::study {

void add_month_command(CLI::App& app, int& status) {
  static MonthOptions month;
  CLI::App* month_command =
      app.add_subcommand("months", "days of the live daemon with drawn faults, in drive time");
  month_command->add_option("--days", month.days, "days (30)");
  month_command->add_option("--seed", month.seed, "seed of the faults (1)");
  month_command->callback([&status] { status = simulate_month(month).print(std::cout) ? 0 : 1; });
}

}  // namespace infuse::study
