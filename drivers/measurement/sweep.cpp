#include "drivers/measurement/sweep.hpp"

namespace infuse {
namespace {

template <class Action>
void for_each_field(Sweep& sweep, Action action) {
  action(sweep.x);
  action(sweep.y);
  action(sweep.z);
  action(sweep.range);
  action(sweep.reflectivity);
  action(sweep.ring);
  action(sweep.column);
  action(sweep.time_offset_ns);
  action(sweep.return_kind);
}

}  // namespace

void Sweep::resize(size_t returns) {
  for_each_field(*this, [&](auto& field) { field.resize(returns); });
}

void Sweep::reserve(size_t returns) {
  for_each_field(*this, [&](auto& field) { field.reserve(returns); });
}

void Sweep::clear() {
  for_each_field(*this, [](auto& field) { field.clear(); });
  gaps.clear();
  stamp = Stamp();
  span = Duration::zero();
  rings = 0;
  columns = 0;
  has_times = true;
  deskewed = false;
  clock = ClockState();
  lost_packets = 0;
  sequence = 0;
}

}  // namespace infuse
