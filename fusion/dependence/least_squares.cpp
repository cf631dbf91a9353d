#include "fusion/dependence/least_squares.hpp"

#include <algorithm>

namespace infuse::dependence {

std::optional<std::string> FitOptions::invalid() const {
  const auto outside = [](const std::vector<double>& list, double low, double high) {
    return list.empty() ||
           !std::all_of(list.begin(), list.end(), [&](double v) { return v >= low && v <= high; });
  };
  if (centres < 1 || centres > 10000) return "centres must be between 1 and 10000";
  if (outside(sigmas, 1e-50, 1e50)) return "sigmas must be a list of widths between 1e-50 and 1e50";
  if (outside(lambdas, 1e-12, 1e12))
    return "lambdas must be a list of ridges between 1e-12 and 1e12";
  if (folds < 2) return "folds must be 2 or more";
  return std::nullopt;
}

}  // namespace infuse::dependence
