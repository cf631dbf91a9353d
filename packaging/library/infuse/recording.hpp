#pragma once

/// @file
/// Captures and drives: readers and writers.

#include "drivers/recording/drive.hpp"
#include "drivers/recording/drive_source.hpp"
#include "drivers/recording/drive_writer.hpp"
#include "drivers/recording/pcap_reader.hpp"
#include "drivers/recording/sweep_export.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "infuse/layout.hpp"
