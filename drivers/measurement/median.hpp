#pragma once

#include <algorithm>
#include <cstddef>
#include <ranges>

namespace infuse {

/// The `rank`-th smallest of some numbers (0: the smallest), which it reorders: smaller ones stand
/// before it. `rank` must be below their number.
template <std::ranges::random_access_range Numbers>
auto nth_smallest(Numbers&& numbers, size_t rank) {
  const auto at = std::ranges::begin(numbers) + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(std::ranges::begin(numbers), at, std::ranges::end(numbers));
  return *at;
}

/// Median of some numbers, at least one, which it reorders; of an even number the upper one of the
/// two in the middle.
template <std::ranges::random_access_range Numbers>
auto median(Numbers&& numbers) {
  return nth_smallest(numbers, std::ranges::size(numbers) / 2);
}

}  // namespace infuse
