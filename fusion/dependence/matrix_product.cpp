#include "fusion/dependence/matrix_product.hpp"

#include <algorithm>
#include <cstring>

namespace infuse::dependence {
namespace {

using Eigen::Index;

constexpr Index kInner = 128;    // inner indices of one packed block
constexpr Index kColumns = 120;  // columns of b in one packed block; a multiple of every tile's
constexpr Index kMaxTileRows = 16;

// What one instruction set holds in registers: a tile of kVectors·kLanes rows × kTileColumns.
struct Baseline {
  using Vector [[gnu::vector_size(16)]] = double;
  static constexpr Index kLanes = 2, kVectors = 2, kTileColumns = 4;
};
struct Avx2 {
  using Vector [[gnu::vector_size(32)]] = double;
  static constexpr Index kLanes = 4, kVectors = 2, kTileColumns = 6;
};
struct Avx512 {
  using Vector [[gnu::vector_size(64)]] = double;
  static constexpr Index kLanes = 8, kVectors = 2, kTileColumns = 8;
};

// `count` vectors of length `inner` as [inner][width], padded with zeros.
template <Index width>
[[gnu::always_inline]] inline void pack(const double* from, Index count, Index inner,
                                        Index count_stride, Index inner_stride, double* to) {
  if (count < width) std::fill(to, to + inner * width, 0.0);
  if (count_stride == 1 && count == width) {
    for (Index k = 0; k < inner; ++k) {
      std::memcpy(to + k * width, from + k * inner_stride, width * sizeof(double));
    }
    return;
  }
  for (Index i = 0; i < count; ++i) {
    for (Index k = 0; k < inner; ++k) {
      to[k * width + i] = from[i * count_stride + k * inner_stride];
    }
  }
}

// tile += a · b over `inner` packed indices; tile is [column][row].
template <class Set>
[[gnu::always_inline]] inline void add_tile(const double* a, const double* b, Index inner,
                                            double* tile) {
  using Vector = typename Set::Vector;
  Vector sum[Set::kTileColumns][Set::kVectors];
  std::memcpy(&sum, tile, sizeof(sum));
  for (Index k = 0; k < inner; ++k) {
    Vector row[Set::kVectors];
    std::memcpy(&row, a, sizeof(row));
#pragma GCC unroll 8
    for (Index c = 0; c < Set::kTileColumns; ++c) {
#pragma GCC unroll 2
      for (Index v = 0; v < Set::kVectors; ++v) sum[c][v] += row[v] * b[c];
    }
    a += Set::kVectors * Set::kLanes;
    b += Set::kTileColumns;
  }
  std::memcpy(tile, &sum, sizeof(sum));
}

template <class Set>
[[gnu::always_inline]] inline void multiply_with(const MatrixView& a, const MatrixView& b,
                                                 double* out, Index out_stride, bool lower_only) {
  constexpr Index kTileRows = Set::kVectors * Set::kLanes;
  static_assert(kTileRows <= kMaxTileRows && kColumns % Set::kTileColumns == 0);
  alignas(64) double packed_a[kInner * kTileRows];
  alignas(64) double packed_b[kInner * kColumns];
  alignas(64) double tile[kTileRows * Set::kTileColumns];
  for (Index c = 0; c < b.columns; ++c) std::fill_n(out + c * out_stride, a.rows, 0.0);

  for (Index c0 = 0; c0 < b.columns; c0 += kColumns) {
    const Index columns = std::min(kColumns, b.columns - c0);
    for (Index k0 = 0; k0 < a.columns; k0 += kInner) {
      const Index inner = std::min(kInner, a.columns - k0);
      for (Index c = 0; c < columns; c += Set::kTileColumns) {
        pack<Set::kTileColumns>(b.data + k0 * b.row_stride + (c0 + c) * b.column_stride,
                                std::min(Set::kTileColumns, columns - c), inner, b.column_stride,
                                b.row_stride, packed_b + c * inner);
      }
      for (Index r = 0; r < a.rows; r += kTileRows) {
        const Index rows = std::min(kTileRows, a.rows - r);
        if (lower_only && r + rows <= c0) continue;
        pack<kTileRows>(a.data + r * a.row_stride + k0 * a.column_stride, rows, inner, a.row_stride,
                        a.column_stride, packed_a);
        for (Index c = 0; c < columns; c += Set::kTileColumns) {
          if (lower_only && r + rows <= c0 + c) break;
          const Index tile_columns = std::min(Set::kTileColumns, columns - c);
          double* corner = out + r + (c0 + c) * out_stride;
          std::fill(tile, tile + kTileRows * Set::kTileColumns, 0.0);
          for (Index j = 0; j < tile_columns; ++j) {
            std::copy_n(corner + j * out_stride, rows, tile + j * kTileRows);
          }
          add_tile<Set>(packed_a, packed_b + c * inner, inner, tile);
          for (Index j = 0; j < tile_columns; ++j) {
            std::copy_n(tile + j * kTileRows, rows, corner + j * out_stride);
          }
        }
      }
    }
  }
}

void multiply_baseline(const MatrixView& a, const MatrixView& b, double* out, Index out_stride,
                       bool lower_only) {
  multiply_with<Baseline>(a, b, out, out_stride, lower_only);
}

[[gnu::target("avx2")]] void multiply_avx2(const MatrixView& a, const MatrixView& b, double* out,
                                           Index out_stride, bool lower_only) {
  multiply_with<Avx2>(a, b, out, out_stride, lower_only);
}

[[gnu::target("arch=x86-64-v4")]] void multiply_avx512(const MatrixView& a, const MatrixView& b,
                                                       double* out, Index out_stride,
                                                       bool lower_only) {
  multiply_with<Avx512>(a, b, out, out_stride, lower_only);
}

void multiply_dispatched(const MatrixView& a, const MatrixView& b, double* out, Index out_stride,
                         bool lower_only, InstructionSet set) {
  switch (set) {
    case InstructionSet::kAvx512:
      return multiply_avx512(a, b, out, out_stride, lower_only);
    case InstructionSet::kAvx2:
      return multiply_avx2(a, b, out, out_stride, lower_only);
    case InstructionSet::kBaseline:
      return multiply_baseline(a, b, out, out_stride, lower_only);
  }
}

}  // namespace

void multiply(const MatrixView& a, const MatrixView& b, double* out, Index out_stride,
              InstructionSet set) {
  multiply_dispatched(a, b, out, out_stride, false, set);
}

void multiply_by_transpose(const MatrixView& a, double* out, Index out_stride, InstructionSet set) {
  const MatrixView transpose{a.data, a.columns, a.rows, a.column_stride, a.row_stride};
  multiply_dispatched(a, transpose, out, out_stride, true, set);
  for (Index c = 0; c < a.rows; ++c) {
    for (Index r = 0; r < c; ++r) out[r + c * out_stride] = out[c + r * out_stride];
  }
}

}  // namespace infuse::dependence
