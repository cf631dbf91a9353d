#pragma once

#include <vector>

#include "drivers/import/import_files.hpp"

namespace infuse::importers {

/// Finds at which azimuth each ring of an HDL-64E begins and ends its turn. The sensor cuts its
/// turns at one position of the rotor, while the lasers point up to 9° to either side of it. All
/// lasers fire at the same positions of the rotor, which are reported in steps of 0.09°: usually
/// two steps from one firing to the next, from time to time one. Where those single steps are,
/// shifted from ring to ring, shows the lasers' azimuths relative to each other. Their mean is
/// taken as `cut_deg`. Uses up to 50 sweeps, evenly chosen, of the usual number of rings. Returns
/// one azimuth for each ring, from below, in degrees; a ring that does not show it clearly has
/// `cut_deg`. Returns nothing if more than a quarter of the rings do not.
std::vector<double> find_ring_cuts(const std::vector<StampedFile>& sweeps, double cut_deg);

}  // namespace infuse::importers
