#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace infuse::study {

/// Optimises graphs (g2o files, those ending in .xz decompressed) with both costs, from the chordal
/// initialisation and from odometry, and prints a table of costs, iterations and processor time.
void optimize_graphs(std::ostream& out, const std::vector<std::string>& files);

/// Adds false closures to graphs, a tenth and half of the number of true ones, alone and in groups,
/// from seeds 1 to `seeds`, and prints how many are rejected and how far the poses are from the
/// optimum without them.
void reject_false_closures(std::ostream& out, const std::vector<std::string>& files, int seeds);

}  // namespace infuse::study
