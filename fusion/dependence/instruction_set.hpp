#pragma once

namespace infuse::dependence {

/// Which vector instructions a kernel of this folder is compiled for. Every variant does the same
/// arithmetic on every number in the same order, so all give the same bytes; only the time differs.
enum class InstructionSet {
  kBaseline,  ///< x86-64: SSE2
  kAvx2,      ///< AVX2
  kAvx512,    ///< x86-64-v4: AVX-512 F, BW, CD, DQ, VL
};

/// Whether this processor runs `set`.
bool supported(InstructionSet set);

/// The widest set that this processor runs.
InstructionSet best_instruction_set();

/// N doubles side by side in GCC's vector types: 2 for SSE2, 4 for AVX2, 8 for AVX-512.
template <int N>
struct Lanes {
  using Vector [[gnu::vector_size(N * 8)]] = double;       ///< the numbers
  using Integers [[gnu::vector_size(N * 8)]] = long long;  ///< their bits, and what compares give
  static constexpr int kLanes = N;
};

}  // namespace infuse::dependence
