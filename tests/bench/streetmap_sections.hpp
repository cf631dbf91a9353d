#pragma once

#include <cstdio>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "tests/bench/streetmap_runs.hpp"

/// Sections of the tables behind fusion/streetmap/accuracy.md.
namespace infuse::streetmap::bench {

/// Text of a format of printf, of at most 255 bytes.
template <class... Values>
std::string format_text(const char* format, Values... values) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

/// Header of the table whose rows `write_row` writes.
inline constexpr const char* kTableHeader =
    "| | lateral, m | longitudinal, m | total, m | heading, ° | ends within 2 m | TRACKING | LOST "
    "| "
    "within 99 % |\n|---|---|---|---|---|---|---|---|---|\n";

/// Writes a row: `what` was run, and how well.
void write_row(std::ostream& out, const std::string& what, const Summary& s);

/// Views of a drive, its map, and the number of seeds.
struct TestDrive {
  std::string drive;
  std::vector<View> views;  ///< empty if the drive is not available
  DriveMap made;
  int seeds = 0;

  /// Runs all seeds.
  Summary run(const RunOptions& options) const {
    return run_seeds(made.map, views, options, seeds);
  }
};

/// Writes the rows of a section for a drive.
using RowWriter = std::function<void(std::ostream&, const TestDrive&)>;

/// Writes the section of a drive: its name and its rows. False if the drive is not available.
bool write_drive_section(std::ostream& out, const std::string& drive, int seeds,
                         const RowWriter& rows);

/// Single images, by measure and by resolution. False if the drive is not available.
bool one_image(std::ostream& out, int images);

/// The tracker on a drive.
void one_drive(std::ostream& out, const TestDrive& test_drive);
/// Streets without buildings, on as many drives.
bool bare(std::ostream& out, int drives);
/// The kind of drive of the thesis, and the measures that it compares.
void robot(std::ostream& out, const TestDrive& test_drive);
/// The tracker with initial poses that are wrong by 1 to 6 m.
void wrong_initial_poses(std::ostream& out, const TestDrive& test_drive);
/// The tracker with noise of the odometry.
void noisy_odometry(std::ostream& out, const TestDrive& test_drive);
/// The tracker with cross-validations left out.
void omission(std::ostream& out, const TestDrive& test_drive);
/// The tracker on maps that were changed.
void wrong_maps(std::ostream& out, const TestDrive& test_drive);

/// Right and wrong starts that are stated.
void given_starts(std::ostream& out, const TestDrive& test_drive);
/// From nothing: by the drive alone, and with what the sensors see.
void from_nothing(std::ostream& out, const TestDrive& test_drive);

/// The search of all streets on large maps, with as many drives on each.
bool large_maps(std::ostream& out, int drives);

/// The search of all streets where two places look alike.
bool alike_streets(std::ostream& out, int drives);

/// Wheels that lie.
void wheels(std::ostream& out, const TestDrive& test_drive);

}  // namespace infuse::streetmap::bench
