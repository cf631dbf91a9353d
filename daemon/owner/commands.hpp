#pragma once

#include "daemon/command_line/command.hpp"

namespace infuse::daemon {

/// Each declares one sub-command of `infuse`, its arguments and its examples.
Command declare_status(CLI::App& infuse);
Command declare_watch(CLI::App& infuse);
Command declare_wait_ready(CLI::App& infuse);
Command declare_inspect(CLI::App& infuse);
Command declare_decode(CLI::App& infuse);
Command declare_evaluate(CLI::App& infuse);
Command declare_calibration(CLI::App& infuse);
Command declare_calibrations(CLI::App& infuse);
Command declare_recalibrate(CLI::App& infuse);
Command declare_apply(CLI::App& infuse);
Command declare_rollback(CLI::App& infuse);
Command declare_freeze(CLI::App& infuse);
Command declare_streetmap(CLI::App& infuse);
Command declare_record(CLI::App& infuse);
Command declare_odometry(CLI::App& infuse);
Command declare_history(CLI::App& infuse);
Command declare_report(CLI::App& infuse);
Command declare_config(CLI::App& infuse);
Command declare_diagnose(CLI::App& infuse);

}  // namespace infuse::daemon
