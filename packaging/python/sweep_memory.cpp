#include "packaging/python/sweep_memory.hpp"

#include <mutex>
#include <vector>

namespace infuse::python {
namespace {

constexpr size_t kMaxKept = 3;  // one that is decoded, one in use, one in between

struct Kept {
  std::mutex mutex;
  std::vector<Sweep> sweeps;
};

Kept& kept() {
  static Kept* const kept = new Kept;  // Python drops sweeps until the very end of the process
  return *kept;
}

}  // namespace

Sweep recycled_sweep() {
  const std::scoped_lock lock(kept().mutex);
  if (kept().sweeps.empty()) return {};
  Sweep sweep = std::move(kept().sweeps.back());
  kept().sweeps.pop_back();
  return sweep;
}

void SweepRecycler::operator()(Sweep* sweep) const {
  {
    const std::scoped_lock lock(kept().mutex);
    if (kept().sweeps.size() < kMaxKept) {
      sweep->clear();
      kept().sweeps.push_back(std::move(*sweep));
    }
  }
  delete sweep;
}

}  // namespace infuse::python
