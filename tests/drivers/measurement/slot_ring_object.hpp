#pragma once

#include "drivers/measurement/slot_ring.hpp"

#include <algorithm>
#include <chrono>
#include <vector>

namespace infuse {

using namespace std::chrono_literals;

inline Stamp at(int64_t ns) { return Stamp::from_ns(ns); }

/// A large object whose every entry is its number.
struct Object {
  Stamp stamp;
  uint64_t number = 0;
  std::vector<uint64_t> body = std::vector<uint64_t>(200);

  void fill(uint64_t its_number, Stamp its_stamp) {
    stamp = its_stamp;
    number = its_number;
    std::fill(body.begin(), body.end(), its_number);
  }
  bool is_intact() const {
    return std::all_of(body.begin(), body.end(), [&](uint64_t entry) { return entry == number; });
  }
};

using Ring = SlotRing<Object>;

}  // namespace infuse
