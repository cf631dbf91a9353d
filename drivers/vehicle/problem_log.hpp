#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::vehicle {

/// Problems of an input that is read on regardless: the first ones in full, and their number.
/// Bounded, so that a corrupt file does not fill the memory.
class ProblemLog {
 public:
  static constexpr size_t kMaxKept = 100;

  /// Counts a problem, and stores it if it is among the first `kKept`.
  void add(Error problem) {
    if (problems_.size() < kMaxKept) problems_.push_back(std::move(problem));
    ++count_;
  }

  /// The first problems, at most `kKept`.
  std::span<const Error> first() const { return problems_; }

  /// Number of all problems, including those that were not stored.
  uint64_t count() const { return count_; }

 private:
  std::vector<Error> problems_;
  uint64_t count_ = 0;
};

}  // namespace infuse::vehicle
