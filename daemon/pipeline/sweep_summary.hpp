#pragma once

#include <cstdint>

#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::daemon {

/// What is told of a sweep.
SweepReport summarise(const Sweep& sweep, uint32_t device);

}  // namespace infuse::daemon
