#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace infuse::study {

/// What a vehicle that is lost found on the map of a town within the next metres.
struct HousesTrial {
  uint64_t seed = 0;          ///< of the town that was mapped
  bool other_houses = false;  ///< the visit is to the same streets in a town of another seed; else
                              ///< to the same town in another season
  double start = 0;           ///< m along the visit
  double found = -1;          ///< m until TRACKING; −1: not within 60 m
  double error = 0;           ///< m, the largest while TRACKING, horizontal
};

/// Rows of a table, with one of names before them.
std::vector<HousesTrial> read_houses_trials(std::istream& in);
void write_houses_header(std::ostream& out);
void write_houses_trial(std::ostream& out, const HousesTrial& trial);

/// Maps a town of Altfeld's streets in summer, and finds the vehicle without an initial pose, in a
/// trial every 30 m up to 80 m before the end, on a visit in autumn, with building sites and other
/// cars, and on a visit to the same streets with other houses, trees and cars. Odd seeds visit
/// against the map's direction. VLP-16; sweeps 1 m apart, with the true motion between them and
/// poses of the map that are true. Throws std::runtime_error.
std::vector<HousesTrial> try_other_houses(const std::string& map, uint64_t seed);

/// Counts of the trials.
void write_houses_table(std::ostream& out, const std::vector<HousesTrial>& trials);

}  // namespace infuse::study
