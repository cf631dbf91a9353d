#pragma once

#include <cstdint>
#include <iosfwd>

namespace infuse::study {

/// Drives `drives` vehicles, drawn from `seed` on, without faults and with motion that no sensor
/// measures, as large as the options state, by each combination of sources. Writes the squared
/// errors of motions over 1, 10 and 60 s, at their end, over the variances that are stated.
void write_consistency(std::ostream& out, uint64_t seed, int drives);

}  // namespace infuse::study
