#pragma once

#include <cstdint>
#include <span>

namespace infuse::features {

/// Replaces every value by its rank among all, divided by their number: 0 ≤ … < 1; equal values
/// share the mean of their ranks. A histogram over ranks is evenly filled whatever the sensor's
/// response, and a monotone change of that response changes nothing.
void equalize(std::span<float> values);

/// The same within each group: only values of one group are ranked against each other. NaN stays
/// NaN and is not counted. One entry a value in `group`.
void equalize_within_groups(std::span<const uint16_t> group, std::span<float> values);

/// The same over all values of 0 … `max_value`, which are divided into 1024 equal levels (larger
/// ones share the last). NaN stays NaN. Allocates nothing.
void equalize_by_level(std::span<float> values, float max_value);

}  // namespace infuse::features
