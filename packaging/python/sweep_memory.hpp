#pragma once

#include "drivers/measurement/sweep.hpp"

namespace infuse::python {

/// An empty sweep with the memory of one that Python has dropped, if there is one: the pages of a
/// new one take longer to get than a sweep takes to decode. Any thread.
Sweep recycled_sweep();

/// Keeps the memory of a sweep, of few at a time, and deletes it: how Python drops sweeps.
struct SweepRecycler {
  void operator()(Sweep* sweep) const;
};

}  // namespace infuse::python
