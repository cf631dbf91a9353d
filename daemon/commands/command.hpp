#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace infuse::daemon {

/// A sub-command of `infuse`.
struct Command {
  CLI::App* app;  ///< its `parsed()` is true if the sub-command was given
  std::function<int()>
      run;  ///< runs the command after the arguments have been parsed; returns the exit code
};

/// Each declares one sub-command, its arguments and its examples.
Command declare_status(CLI::App& infuse);
Command declare_watch(CLI::App& infuse);
Command declare_wait_ready(CLI::App& infuse);
Command declare_inspect(CLI::App& infuse);
Command declare_decode(CLI::App& infuse);
Command declare_import(CLI::App& infuse);
Command declare_calibrate_target(CLI::App& infuse);
Command declare_evaluate(CLI::App& infuse);
Command declare_calibrate(CLI::App& infuse);
Command declare_calibration(CLI::App& infuse);
Command declare_recalibrate(CLI::App& infuse);
Command declare_apply(CLI::App& infuse);
Command declare_rollback(CLI::App& infuse);
Command declare_freeze(CLI::App& infuse);
Command declare_streetmap(CLI::App& infuse);
Command declare_record(CLI::App& infuse);
Command declare_odometry(CLI::App& infuse);
Command declare_align(CLI::App& infuse);
Command declare_history(CLI::App& infuse);
Command declare_export(CLI::App& infuse);
Command declare_report(CLI::App& infuse);
Command declare_map(CLI::App& infuse);
Command declare_places(CLI::App& infuse);
Command declare_fleet(CLI::App& infuse);

}  // namespace infuse::daemon
