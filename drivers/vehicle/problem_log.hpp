#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::vehicle {

/// What was wrong with an input that is read on regardless: the first problems in full, and how
/// many there were. Bounded, so that a file of rubbish does not fill the memory.
class ProblemLog {
 public:
  static constexpr size_t kMaxKept = 100;

  /// Counts a problem, and keeps it if it is among the first `kKept`.
  void add(Error problem) {
    if (problems_.size() < kMaxKept) problems_.push_back(std::move(problem));
    ++count_;
  }

  /// The first problems, at most `kKept`.
  std::span<const Error> first() const { return problems_; }

  /// All problems, also those that were not kept.
  uint64_t count() const { return count_; }

 private:
  std::vector<Error> problems_;
  uint64_t count_ = 0;
};

}  // namespace infuse::vehicle
