#include "fusion/dependence/column_sums.hpp"

#include <cstring>

#include "drivers/measurement/simd.hpp"
#include "fusion/dependence/lanes.hpp"

namespace infuse::dependence {
namespace {

using Eigen::Index;

// Sums of `kLanes · kVectors` rows, kept in registers.
template <class Set, Index vectors>
[[gnu::always_inline]] inline void sum_rows(const double* data, Index stride,
                                            std::span<const int> columns, double* out) {
  using Vector = typename Set::Vector;
  Vector sum[vectors] = {};
  for (const int column : columns) {
    Vector entries[vectors];
    std::memcpy(&entries, data + column * stride, sizeof(entries));
    for (Index v = 0; v < vectors; ++v) sum[v] += entries[v];
  }
  std::memcpy(out, &sum, sizeof(sum));
}

template <class Set>
[[gnu::always_inline]] inline void sum_with(const double* matrix, Index rows,
                                            std::span<const int> columns, double* out) {
  constexpr Index kLanes = Set::kLanes;
  Index r = 0;
  for (; r + 4 * kLanes <= rows; r += 4 * kLanes) {
    sum_rows<Set, 4>(matrix + r, rows, columns, out + r);
  }
  for (; r + kLanes <= rows; r += kLanes) {
    sum_rows<Set, 1>(matrix + r, rows, columns, out + r);
  }
  for (; r < rows; ++r) sum_rows<Lanes<1>, 1>(matrix + r, rows, columns, out + r);
}

void sum_baseline(const double* matrix, Index rows, std::span<const int> columns, double* out) {
  sum_with<Lanes<2>>(matrix, rows, columns, out);
}

INFUSE_TARGET("avx2")
void sum_avx2(const double* matrix, Index rows, std::span<const int> columns, double* out) {
  sum_with<Lanes<4>>(matrix, rows, columns, out);
}

INFUSE_TARGET("arch=x86-64-v4")
void sum_avx512(const double* matrix, Index rows, std::span<const int> columns, double* out) {
  sum_with<Lanes<8>>(matrix, rows, columns, out);
}

}  // namespace

void sum_columns(const double* matrix, Index rows, std::span<const int> columns, double* out,
                 InstructionSet set) {
  select_variant(set, sum_baseline, sum_avx2, sum_avx512)(matrix, rows, columns, out);
}

}  // namespace infuse::dependence
