#include "drivers/import/ring_cuts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "drivers/recording/sweep_files.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {
namespace {

constexpr size_t kRings = 16;

// Lasers that point to either side of the rotor's position, by up to 9 deg.
double offset_deg(size_t ring) { return -9 + 3.27 * static_cast<double>(ring * 5 % 6); }

class RingCutsTest : public ::testing::Test {
 protected:
  // Writes sweeps of a rotor whose speed wavers; its positions are reported in steps of `step_deg`.
  // A tenth of the returns is missing, and the rings from `empty_from` on are hardly seen.
  std::vector<StampedFile> write_sweeps(double step_deg, size_t empty_from = kRings) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::vector<StampedFile> files;
    for (size_t k = 0; k < 20; ++k) {
      std::vector<double> rotor;
      for (double position = uniform(random) * 0.1; position < 360;) {
        rotor.push_back(step_deg > 0 ? std::floor(position / step_deg) * step_deg : position);
        position += 0.1728 + 0.004 * (uniform(random) - 0.5);
      }
      Sweep sweep;
      for (size_t from_top = 0; from_top < kRings; ++from_top) {
        const size_t ring = kRings - 1 - from_top;
        std::vector<double> azimuths;
        for (const double position : rotor) {
          if (uniform(random) < (ring >= empty_from ? 0.97 : 0.1)) continue;
          const double azimuth = std::fmod(180 + offset_deg(ring) - position + 720, 360);
          azimuths.push_back(azimuth * M_PI / 180);
        }
        std::sort(azimuths.begin(), azimuths.end());
        for (const double azimuth : azimuths) append(azimuth, -0.02 * double(from_top), sweep);
      }
      const auto path = folder_ / (std::to_string(k) + ".bin");
      EXPECT_TRUE(recording::write_sweep_bin(path, sweep));
      files.push_back({{}, path, k});
    }
    return files;
  }

  static void append(double azimuth, double slope, Sweep& sweep) {
    const size_t i = sweep.size();
    sweep.resize(i + 1);
    sweep.x[i] = static_cast<float>(20 * std::cos(azimuth));
    sweep.y[i] = static_cast<float>(20 * std::sin(azimuth));
    sweep.z[i] = static_cast<float>(20 * slope);
    sweep.reflectivity[i] = 0.5F;
  }

  ScratchFolder folder_;
};

TEST_F(RingCutsTest, AreWhereTheRotorIsCut) {
  const std::vector<double> cuts = find_ring_cuts(write_sweeps(0.09), 180);
  ASSERT_EQ(cuts.size(), kRings);
  double mean = 0;
  for (size_t ring = 0; ring < kRings; ++ring) mean += offset_deg(ring) / kRings;
  for (size_t ring = 0; ring < kRings; ++ring)
    EXPECT_NEAR(cuts[ring], 180 + offset_deg(ring) - mean, 0.2) << ring;
}

TEST_F(RingCutsTest, OfARingThatIsHardlySeenIsTheOneOfAll) {
  const std::vector<double> cuts = find_ring_cuts(write_sweeps(0.09, kRings - 1), 180);
  ASSERT_EQ(cuts.size(), kRings);
  EXPECT_EQ(cuts.back(), 180);
  EXPECT_NEAR(cuts[1] - cuts[0], offset_deg(1) - offset_deg(0), 0.2);
}

TEST_F(RingCutsTest, AreNotMadeUpWhereNothingShowsThem) {
  EXPECT_TRUE(find_ring_cuts(write_sweeps(0), 180).empty());
  EXPECT_TRUE(find_ring_cuts(write_sweeps(0.09, kRings / 2), 180).empty());
  EXPECT_TRUE(find_ring_cuts({}, 180).empty());
}

}  // namespace
}  // namespace infuse::importers
