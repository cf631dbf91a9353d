#include "fusion/dependence/histogram_measures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "tests/fusion/dependence/joint_table.hpp"

namespace infuse::dependence {
namespace {

constexpr double kReferenceTolerance = 5e-13;
JointHistogram reference_table() {
  return joint_table(std::vector<double>{1, 2, 3, 6, 5, 4}, 2, 3);
}

/// Returns a random table of integer counts.
JointHistogram random_table(unsigned seed, int bins_x, int bins_y) {
  std::mt19937 random(seed);
  std::poisson_distribution<int> draw(3);
  std::vector<double> mass(static_cast<size_t>(bins_x * bins_y));
  for (double& m : mass) m = draw(random);
  return joint_table(mass, bins_x, bins_y);
}

JointHistogram transposed(const JointHistogram& h) {
  std::vector<double> mass;
  for (int y = 0; y < h.bins_y; ++y) {
    for (int x = 0; x < h.bins_x; ++x) mass.push_back(h.at(x, y));
  }
  return joint_table(mass, h.bins_y, h.bins_x);
}

// Reference values: R package `entropy` 1.3.2.
TEST(HistogramMeasures, ReferenceTable) {
  const JointHistogram table = reference_table();
  const Measure information = Measure::kMutualInformation;
  EXPECT_NEAR(measure(information, table).value, 0.034504918061, kReferenceTolerance);
  for (const MeasureName& each : kMeasureNames) EXPECT_TRUE(measure(each.measure, table).usable());
}

TEST(HistogramMeasures, ChiSquaredAndSquaredLossAreTheirDefinitions) {
  const JointHistogram table = reference_table();
  double chi_squared = 0;
  for (int x = 0; x < 2; ++x) {
    for (int y = 0; y < 3; ++y) {
      double px = 0, py = 0;
      for (int k = 0; k < 3; ++k) px += table.at(x, k) / 21;
      for (int k = 0; k < 2; ++k) py += table.at(k, y) / 21;
      const double gap = table.at(x, y) / 21 - px * py;
      chi_squared += gap * gap / (px * py);
    }
  }
  EXPECT_NEAR(measure(Measure::kChiSquared, table).value, chi_squared, 1e-14);
  EXPECT_NEAR(measure(Measure::kSquaredLossMutualInformation, table).value, chi_squared / 2, 1e-14);
}

TEST(HistogramMeasures, BoundsSymmetryAndRelabelling) {
  std::mt19937 random(5);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const JointHistogram table = random_table(seed, 6, 4);
    // Relabelled: rows and columns permuted.
    std::vector<int> rows = {0, 1, 2, 3, 4, 5}, columns = {0, 1, 2, 3};
    std::shuffle(rows.begin(), rows.end(), random);
    std::shuffle(columns.begin(), columns.end(), random);
    std::vector<double> mass;
    for (const int x : rows) {
      for (const int y : columns) mass.push_back(table.at(x, y));
    }
    const JointHistogram relabelled = joint_table(mass, 6, 4);
    for (const MeasureName& each : kMeasureNames) {
      const Measure which = each.measure;
      const double value = measure(which, table).value;
      EXPECT_GE(value, 0);
      EXPECT_NEAR(value, measure(which, transposed(table)).value, 1e-12);
      EXPECT_NEAR(value, measure(which, relabelled).value, 1e-12);
    }
    EXPECT_LE(measure(Measure::kNormalisedMutualInformation, table).value, 2);
  }
}

TEST(HistogramMeasures, ProductTableIsIndependentAndDiagonalIsComplete) {
  const JointHistogram product =
      joint_table(std::vector<double>{2, 4, 6, 5, 10, 15, 3, 6, 9}, 3, 3);
  EXPECT_NEAR(measure(Measure::kMutualInformation, product).value, 0, 1e-14);
  EXPECT_NEAR(measure(Measure::kChiSquared, product).value, 0, 1e-14);
  EXPECT_NEAR(measure(Measure::kNormalisedMutualInformation, product).value, 1, 1e-14);
  const JointHistogram diagonal = joint_table(std::vector<double>{5, 0, 0, 0, 5, 0, 0, 0, 5}, 3, 3);
  EXPECT_NEAR(measure(Measure::kMutualInformation, diagonal).value, std::log(3), 1e-14);
  EXPECT_NEAR(measure(Measure::kChiSquared, diagonal).value, 2, 1e-14);
}

/// Moves a little mass along y and compares with the difference quotient.
TEST(HistogramMeasures, SensitivityAgreesWithCentralDifferences) {
  const JointHistogram table = random_table(3, 5, 7);
  Sensitivity sensitivity;
  for (const MeasureName& each : kMeasureNames) {
    const Measure which = each.measure;
    differentiate(which, table, sensitivity);
    EXPECT_NEAR(sensitivity.estimate.value, measure(which, table).value, 1e-14);
    for (int x = 0; x < 5; ++x) {
      for (int y = 0; y + 1 < 7; ++y) {
        const auto from = static_cast<size_t>(x * 7 + y);
        if (table.mass[from] == 0 || table.mass[from + 1] == 0) continue;
        const double step = 1e-4;
        const auto moved = [&](double amount) {
          std::vector<double> mass = table.mass;
          mass[from] -= amount * table.total;
          mass[from + 1] += amount * table.total;
          return measure(which, joint_table(mass, 5, 7)).value;
        };
        const double quotient = (moved(step) - moved(-step)) / (2 * step);
        EXPECT_NEAR(sensitivity.table[from + 1] - sensitivity.table[from], quotient,
                    1e-5 * (1 + std::abs(quotient)));
      }
    }
  }
}

TEST(HistogramMeasures, BadTablesGiveAReasonAndAFiniteValue) {
  const std::vector<JointHistogram> tables = {JointHistogram{},
                                              joint_table(std::vector<double>{0, 0, 0, 0}, 2, 2),
                                              joint_table(std::vector<double>{5, 0, 0, 0}, 2, 2),
                                              joint_table(std::vector<double>{5, 5, 0, 0}, 2, 2),
                                              joint_table(std::vector<double>{5, 0, 5, 0}, 2, 2),
                                              joint_table(std::vector<double>{5}, 1, 1)};
  for (const JointHistogram& table : tables) {
    for (const MeasureName& each : kMeasureNames) {
      const Measure which = each.measure;
      const Estimate estimate = measure(which, table);
      EXPECT_FALSE(estimate.usable());
      EXPECT_TRUE(std::isfinite(estimate.value));
    }
  }
}

}  // namespace
}  // namespace infuse::dependence
