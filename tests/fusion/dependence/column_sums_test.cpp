#include "fusion/dependence/column_sums.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/fusion/dependence/random_samples.hpp"

namespace infuse::dependence {
namespace {

TEST(ColumnSums, SameBytesAsTheDefinitionOnEveryInstructionSet) {
  for (const Eigen::Index rows : {1, 2, 5, 8, 31, 40, 100}) {
    const Eigen::MatrixXd matrix = normal_samples(rows, 20, 1);
    const std::vector<int> columns = {3, 19, 0, 7, 7, 12};
    Eigen::VectorXd truth = Eigen::VectorXd::Zero(rows);
    for (const int c : columns) truth += matrix.col(c);
    for (const auto set :
         {InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
      if (!supported(set)) continue;
      Eigen::VectorXd out = Eigen::VectorXd::Constant(rows, 9.0);
      sum_columns(matrix, columns, out.data(), set);
      EXPECT_EQ(out, truth) << rows;
      sum_columns(matrix, {}, out.data(), set);
      EXPECT_EQ(out, Eigen::VectorXd::Zero(rows));
    }
  }
}

}  // namespace
}  // namespace infuse::dependence
