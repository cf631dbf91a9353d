#pragma once

#include <span>

namespace infuse::places {

/// How well a cloud fits at a place, by its verification (`mapping::ClosureCheck`): shares, 0 … 1.
struct PlaceFit {
  double inliers = 0;    ///< of the points that have a counterpart
  double agreement = 0;  ///< of what each can judge of the other, and supports
};

/// Probabilities of where a vehicle is; they add up to at most 1.
struct PlaceProbabilities {
  double best = 0;       ///< of the best fit
  double runner_up = 0;  ///< of the next
  double nowhere = 1;    ///< that it is at none of the places compared
};

/// Logarithm of the odds that a place that fits so well is the right one, against nowhere.
double log_odds(const PlaceFit& fit);

/// Weighs places that fit against each other and against nowhere (a softmax of their log odds).
/// The best fit comes first; without any the vehicle is nowhere.
PlaceProbabilities place_probabilities(std::span<const PlaceFit> fits);

}  // namespace infuse::places
