#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "tests/study/places/true_map.hpp"

namespace infuse::study {

/// Searches the map for every cloud of 4 m of the drives and prints a line for each: for each place
/// that verification accepts its inliers, agreement and error (m). Returns an error text, or
/// nothing. Throws std::runtime_error where the map cannot be read.
std::string study_fits(std::ostream& out, const VisitOptions& options);

/// Reads such lines from files and prints how often places are right by the probability that
/// `places::place_probabilities` states, in bins, with the expected calibration error; with `fit`
/// first the weights of the log odds that make the lines most likely. Returns an error text, or
/// nothing.
std::string study_place_odds(std::ostream& out, const std::vector<std::string>& files, bool fit);

}  // namespace infuse::study
