#include "fusion/dependence/matrix_product.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/fusion/dependence/random_samples.hpp"

namespace infuse::dependence {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr InstructionSet kSets[] = {InstructionSet::kBaseline, InstructionSet::kAvx2,
                                    InstructionSet::kAvx512};

// One running sum per entry, in order of the inner index.
MatrixXd by_definition(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd out(a.rows(), b.cols());
  for (Index r = 0; r < a.rows(); ++r) {
    for (Index c = 0; c < b.cols(); ++c) {
      double sum = 0;
      for (Index k = 0; k < a.cols(); ++k) sum += a(r, k) * b(k, c);
      out(r, c) = sum;
    }
  }
  return out;
}

TEST(MatrixProduct, SameBytesAsTheDefinitionOnEveryInstructionSet) {
  const Index shapes[][3] = {{1, 1, 1},   {3, 5, 2},     {16, 128, 8},  {17, 129, 9},
                             {40, 40, 8}, {24, 300, 31}, {100, 257, 6}, {33, 64, 250}};
  for (const auto& [rows, inner, columns] : shapes) {
    const MatrixXd a = normal_samples(rows, inner, 1), b = normal_samples(inner, columns, 2);
    const MatrixXd truth = by_definition(a, b);
    for (const InstructionSet set : kSets) {
      if (!supported(set)) continue;
      MatrixXd out;
      multiply(a, b, out, set);
      EXPECT_EQ(out, truth) << rows << " × " << inner << " × " << columns;
    }
  }
}

TEST(MatrixProduct, AcceptsTransposesAndBlocks) {
  const MatrixXd a = normal_samples(50, 30, 3), b = normal_samples(50, 20, 4);
  MatrixXd out;
  multiply(a.transpose(), b, out);
  EXPECT_EQ(out, by_definition(a.transpose(), b));
  multiply(a.middleRows(3, 20),
           b.middleRows(5, 30).transpose().leftCols(30).topRows(20).transpose(), out);
  EXPECT_EQ(out, by_definition(a.middleRows(3, 20), b.middleRows(5, 30)));
}

TEST(MatrixProduct, SquareIsSymmetricAndEqualsTheProduct) {
  for (const Index rows : {1, 7, 16, 40, 100, 130, 250}) {
    const MatrixXd a = normal_samples(rows, 150, 5);
    const MatrixXd truth = by_definition(a, a.transpose());
    for (const InstructionSet set : kSets) {
      if (!supported(set)) continue;
      MatrixXd out;
      multiply_by_transpose(a, out, set);
      EXPECT_EQ(out, truth) << rows;
    }
  }
}

TEST(MatrixProduct, EmptySumIsZero) {
  MatrixXd out;
  multiply(MatrixXd(3, 0), MatrixXd(0, 2), out);
  EXPECT_EQ(out, MatrixXd::Zero(3, 2));
}

}  // namespace
}  // namespace infuse::dependence
