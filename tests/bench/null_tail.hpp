#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace infuse::online {

/// How the evidence of a calibration that holds is distributed far out, and so how often it would
/// reach the limit. Evidence rises from nought and falls back again and again; above a few nats the
/// peaks of a sequential test of log-likelihood ratios fall off exponentially (Siegmund 1985).
class NullTail {
 public:
  /// Nats above which peaks count: of what is suspected (`DriftTestOptions::suspect`), where no
  /// single look (`most_a_look`) makes a peak by itself.
  static constexpr double kFrom = 4;

  /// The evidence after one look.
  void add(double evidence) {
    if (evidence > kFrom) {
      peak_ = std::max(peak_, evidence);
    } else {
      end_excursion();
    }
    if (looks_.size() < 8) looks_.resize(8);
    for (size_t level = 0; level < looks_.size(); ++level) {
      looks_[level] += evidence >= static_cast<double>(level) ? 1 : 0;
    }
  }
  void end_excursion() {
    if (peak_ > 0) peaks_.push_back(peak_);
    peak_ = 0;
  }

  size_t peaks() const { return peaks_.size(); }
  /// Share of looks with so many nats at least, 0 … 7.
  double share(size_t level) const {
    return looks_.empty() || looks_[0] == 0 ? 0 : looks_[level] / looks_[0];
  }

  /// Nats by which the peaks fall to 1/e: their mean excess, and its upper 95 % bound.
  double scale() const {
    double sum = 0;
    for (const double peak : peaks_) sum += peak - kFrom;
    return peaks_.empty() ? 0 : sum / static_cast<double>(peaks_.size());
  }
  double upper_scale() const {
    const auto n = static_cast<double>(std::max<size_t>(peaks_.size(), 3));
    return scale() / (1 - 1.645 / std::sqrt(n) + 0.9 / n);  // of χ² with 2n degrees, about
  }

  /// Hours between two alarms at a limit, where so many hours were driven.
  double hours_between(double limit, double hours, double scale) const {
    const double an_hour = static_cast<double>(std::max<size_t>(peaks_.size(), 1)) / hours;
    return std::exp((limit - kFrom) / std::max(scale, 1e-3)) / an_hour;
  }

 private:
  std::vector<double> peaks_;
  std::vector<double> looks_;  // with so many nats or more
  double peak_ = 0;
};

}  // namespace infuse::online
