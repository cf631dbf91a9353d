#include "fusion/dependence/matrix_product.hpp"

#include <algorithm>
#include <cstring>

#include "drivers/measurement/simd.hpp"
#include "fusion/dependence/lanes.hpp"

namespace infuse::dependence {
namespace {

using Eigen::Index;

constexpr Index kInnerBlockSize = 128;   // inner indices per block: one stays in the cache
constexpr Index kColumnBlockSize = 120;  // columns of b per packed block, which stays in the
                                         // cache; a multiple of every tile's

// Register tile of one instruction set: 2 vectors × kTileColumns.
struct Baseline : Lanes<2> {
  static constexpr Index kTileColumns = 4;  // 8 of 16 registers are sums
};
struct Avx2 : Lanes<4> {
  static constexpr Index kTileColumns = 6;  // 12 of 16 registers
};
struct Avx512 : Lanes<8> {
  static constexpr Index kTileColumns = 8;  // 16 of 32 registers
};

// Packs `count` vectors of length `inner` as [inner][width], padded with zeros.
template <Index width>
[[gnu::always_inline]] inline void pack(const double* from, Index count, Index inner,
                                        Index count_stride, Index inner_stride, double* to) {
  if (count < width) std::fill(to, to + inner * width, 0.0);
  for (Index i = 0; i < count; ++i) {
    for (Index k = 0; k < inner; ++k) {
      to[k * width + i] = from[i * count_stride + k * inner_stride];
    }
  }
}

// out (+)= a · b over `inner` indices for one tile; b is packed.
template <class Set, Index vectors>
[[gnu::always_inline]] inline void add_tile(const double* a, Index a_stride, const double* b,
                                            Index inner, double* out, Index out_stride,
                                            bool overwrite) {
  using Vector = typename Set::Vector;
  Vector sum[Set::kTileColumns][vectors] = {};
  if (!overwrite) {
    for (Index c = 0; c < Set::kTileColumns; ++c) {
      std::memcpy(&sum[c], out + c * out_stride, sizeof(sum[c]));
    }
  }
  for (Index k = 0; k < inner; ++k) {
    Vector row[vectors];
    std::memcpy(&row, a, sizeof(row));
#pragma GCC unroll 8
    for (Index c = 0; c < Set::kTileColumns; ++c) {
#pragma GCC unroll 2
      for (Index v = 0; v < vectors; ++v) sum[c][v] += row[v] * b[c];
    }
    a += a_stride;
    b += Set::kTileColumns;
  }
  for (Index c = 0; c < Set::kTileColumns; ++c) {
    std::memcpy(out + c * out_stride, &sum[c], sizeof(sum[c]));
  }
}

// One block of a against a packed block of b.
struct Block {
  const double* a;
  Index row_stride, column_stride;
  const double* packed_b;
  Index columns, inner;
  double* out;
  Index out_stride;
  bool overwrite;    // out is uninitialised
  Index lower_from;  // tiles at or above row = column − lower_from are skipped
};

// Rows [row, row + rows) of a block, rows <= vectors · kLanes.
template <class Set, Index vectors>
[[gnu::always_inline]] inline void add_rows(const Block& block, Index row, Index rows) {
  constexpr Index kTileRows = vectors * Set::kLanes;
  alignas(64) double packed_a[kInnerBlockSize * kTileRows];
  alignas(64) double tile[kTileRows * Set::kTileColumns];
  const double* a = block.a + row * block.row_stride;
  Index a_stride = block.column_stride;
  if (block.row_stride != 1 || rows < kTileRows || block.columns > 64) {
    pack<kTileRows>(a, rows, block.inner, block.row_stride, block.column_stride, packed_a);
    a = packed_a;
    a_stride = kTileRows;
  }
  for (Index c = 0; c < block.columns; c += Set::kTileColumns) {
    if (row + rows + block.lower_from <= c) break;
    const Index columns = std::min(Set::kTileColumns, block.columns - c);
    const double* b = block.packed_b + c * block.inner;
    double* out = block.out + row + c * block.out_stride;
    if (rows == kTileRows && columns == Set::kTileColumns) {
      add_tile<Set, vectors>(a, a_stride, b, block.inner, out, block.out_stride, block.overwrite);
      continue;
    }
    std::fill(tile, tile + kTileRows * Set::kTileColumns, 0.0);
    for (Index j = 0; j < columns && !block.overwrite; ++j) {
      std::copy_n(out + j * block.out_stride, rows, tile + j * kTileRows);
    }
    add_tile<Set, vectors>(a, a_stride, b, block.inner, tile, kTileRows, false);
    for (Index j = 0; j < columns; ++j) {
      std::copy_n(tile + j * kTileRows, rows, out + j * block.out_stride);
    }
  }
}

template <class Set>
[[gnu::always_inline]] inline void multiply_with(const MatrixView& a, const MatrixView& b,
                                                 double* out, Index out_stride, bool lower_only) {
  static_assert(kColumnBlockSize % Set::kTileColumns == 0);
  alignas(64) double packed_b[kInnerBlockSize * kColumnBlockSize];
  if (a.columns == 0) {
    for (Index c = 0; c < b.columns; ++c) std::fill_n(out + c * out_stride, a.rows, 0.0);
  }
  for (Index c0 = 0; c0 < b.columns; c0 += kColumnBlockSize) {
    const Index columns = std::min(kColumnBlockSize, b.columns - c0);
    for (Index k0 = 0; k0 < a.columns; k0 += kInnerBlockSize) {
      const Index inner = std::min(kInnerBlockSize, a.columns - k0);
      for (Index c = 0; c < columns; c += Set::kTileColumns) {
        pack<Set::kTileColumns>(b.data + k0 * b.row_stride + (c0 + c) * b.column_stride,
                                std::min(Set::kTileColumns, columns - c), inner, b.column_stride,
                                b.row_stride, packed_b + c * inner);
      }
      const Block block{a.data + k0 * a.column_stride,
                        a.row_stride,
                        a.column_stride,
                        packed_b,
                        columns,
                        inner,
                        out + c0 * out_stride,
                        out_stride,
                        k0 == 0,
                        lower_only ? -c0 : b.columns};
      for (Index r = 0; r < a.rows;) {
        const Index left = a.rows - r;
        if (left > Set::kLanes) {
          const Index rows = std::min<Index>(2 * Set::kLanes, left);
          add_rows<Set, 2>(block, r, rows);
          r += rows;
        } else {
          add_rows<Set, 1>(block, r, left);
          r += left;
        }
      }
    }
  }
}

void multiply_baseline(const MatrixView& a, const MatrixView& b, double* out, Index out_stride,
                       bool lower_only) {
  multiply_with<Baseline>(a, b, out, out_stride, lower_only);
}

INFUSE_TARGET("avx2")
void multiply_avx2(const MatrixView& a, const MatrixView& b, double* out, Index out_stride,
                   bool lower_only) {
  multiply_with<Avx2>(a, b, out, out_stride, lower_only);
}

INFUSE_TARGET("arch=x86-64-v4")
void multiply_avx512(const MatrixView& a, const MatrixView& b, double* out, Index out_stride,
                     bool lower_only) {
  multiply_with<Avx512>(a, b, out, out_stride, lower_only);
}

void multiply_dispatched(const MatrixView& a, const MatrixView& b, double* out, Index out_stride,
                         bool lower_only, InstructionSet set) {
  select_variant(set, multiply_baseline, multiply_avx2, multiply_avx512)(a, b, out, out_stride,
                                                                         lower_only);
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
