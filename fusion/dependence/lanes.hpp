#pragma once

namespace infuse::dependence {

/// N doubles side by side in GCC's vector types: 2 for SSE2, 4 for AVX2, 8 for AVX-512.
template <int N>
struct Lanes {
  using Vector [[gnu::vector_size(N * 8)]] = double;       ///< the numbers
  using Integers [[gnu::vector_size(N * 8)]] = long long;  ///< their bits and results of compares
  static constexpr int kLanes = N;
};

}  // namespace infuse::dependence
