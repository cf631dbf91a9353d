#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace infuse::study {

/// How upright the map of a drive is.
struct UprightTrial {
  uint64_t seed = 0;
  int shape = 0;      ///< 0 along a street, 1 with turns, 2 with turns and hills
  bool gnss = false;  ///< the map uses fixes
  bool imu = false;   ///< the drive has an inertial unit
  double tilt = 0;    ///< rad, of the vertical at the keyframe where it errs most
  double sigma = 0;   ///< rad, as the map states it
};

/// Rows of a table, with one of names before them.
std::vector<UprightTrial> read_upright_trials(std::istream& in);
void write_upright_header(std::ostream& out);
void write_upright_trial(std::ostream& out, const UprightTrial& trial);

/// Simulates 20 s of a VLP-16 in a town of Altfeld's streets, with the shape, the inertial unit and
/// the fixes that the seed's place among twelve says, into a temporary folder, and maps it as
/// `infuse map` does. Nothing where the map is not usable. Throws std::runtime_error.
std::vector<UprightTrial> try_upright(const std::string& map, uint64_t seed);

/// Tilts, and how many are at most 0.5° or within the 99 % of what is stated.
void write_upright_table(std::ostream& out, const std::vector<UprightTrial>& trials);

}  // namespace infuse::study
