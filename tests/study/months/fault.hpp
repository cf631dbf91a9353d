#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace infuse::study {

/// What goes wrong with a part of the vehicle or its computer, from one second to another. What
/// happens at one moment lasts one second.
struct Fault {
  int64_t from = 0, until = 0;  ///< s since the start: from <= t < until
  std::string subject;          ///< "top", "front", "service", "owner", ...
  std::string kind;             ///< "silent", "restart", ...
  double value = 0;
};

/// Parses "60-70 top silent; 90 service restart; 100-130 top loss 0.01". Throws
/// std::invalid_argument.
std::vector<Fault> parse_faults(std::string_view text);

/// The faults that are present at one second after the other.
class FaultSchedule {
 public:
  explicit FaultSchedule(std::vector<Fault> faults);

  /// Goes on to a second; seconds only grow.
  void advance(int64_t second);

  /// A fault that is present now; null without one.
  const Fault* find(std::string_view subject, std::string_view kind) const;
  bool has(std::string_view subject, std::string_view kind) const {
    return find(subject, kind) != nullptr;
  }

  /// Faults that began since the last `advance`.
  const std::vector<Fault>& begun() const { return begun_; }

 private:
  std::vector<Fault> faults_;  // by begin
  size_t next_ = 0;
  std::vector<Fault> present_, begun_;
};

}  // namespace infuse::study
