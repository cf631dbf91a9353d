#pragma once

#include <random>
#include <vector>

#include "fusion/mapping/pose_graph.hpp"

namespace infuse::study {

/// Adds `count` closures that are false at the poses of `graph`: each states that two places far
/// from each other are one, with the motion and the information of a true closure drawn at random.
/// In groups, 5 to 10 consecutive poses agree on the same error, forwards or backwards along the
/// second place.
template <int D>
void add_false_closures(mapping::PoseGraph<D>& graph, size_t count, bool groups,
                        std::mt19937& random);

}  // namespace infuse::study
