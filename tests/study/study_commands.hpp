#pragma once

#include <CLI/CLI.hpp>

namespace infuse::study {

// The commands of infuse-study. A command sets `status`, the exit status, where that is not 0.

/// Adds the commands that list, run and compare estimators.
void add_estimator_commands(CLI::App& app, int& status);

/// Adds the commands that optimise pose graphs.
void add_mapping_commands(CLI::App& app);

/// Adds the study of odometry on drives whose sources and faults are drawn.
void add_motion_command(CLI::App& app);

/// Adds the study of days of the live daemon.
void add_month_command(CLI::App& app, int& status);

/// Adds the commands that align scans; needs the simulator.
void add_registration_commands(CLI::App& app);

/// Adds the studies of places on a map of keyframes and of their recognition across seasons; needs
/// the simulator.
void add_places_commands(CLI::App& app);

/// Adds the study of trials without an initial pose on a street map; needs the simulator.
void add_starts_command(CLI::App& app);

/// Adds the commands that calibrate rigs drawn at random, and those of a recorded drive: its stated
/// extrinsics, its parts. Without the simulator the former fail with status 3, and the latter are
/// missing.
void add_rigs_commands(CLI::App& app, int& status);

}  // namespace infuse::study
