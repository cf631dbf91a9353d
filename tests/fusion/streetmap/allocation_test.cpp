// After warm-up, collecting and updating do not allocate. The test counts calls of glibc's
// allocator, because Eigen calls it directly.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "fusion/streetmap/tracker.hpp"
#include "tests/fusion/streetmap/town.hpp"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {
std::atomic<bool> counting{false};
std::atomic<int> counted{0};
}  // namespace

extern "C" {
void* __libc_malloc(size_t bytes);
void* __libc_memalign(size_t alignment, size_t bytes);
void* malloc(size_t bytes) {
  if (counting) ++counted;
  return __libc_malloc(bytes);
}
void* aligned_alloc(size_t alignment, size_t bytes) {
  if (counting) ++counted;
  return __libc_memalign(alignment, bytes);
}
}

namespace infuse::streetmap {
namespace {

struct Counting {
  Counting() { counting = true; }
  ~Counting() { counting = false; }
};

TEST(TrackerAllocations, TheCounterCounts) {
  const int before = counted;
  {
    const Counting count;
    const Eigen::MatrixXd matrix = Eigen::MatrixXd::Ones(3, 3);
    EXPECT_EQ(matrix(2, 2), 1);
    const std::vector<int> list(9, 1);
    EXPECT_EQ(list.back(), 1);
  }
  EXPECT_EQ(counted - before, 2);
}

TEST(TrackerAllocations, NoneAfterTheFirstUpdates) {
  const town::Town town = town::build(town::plan());
  TrackerOptions options;
  options.grid.max_samples = 700;
  options.particles.max_count = 150;
  options.skipped_validation_share = 0.5;
  Tracker tracker(town.map, options);
  tracker.start({-80, -1.2, 0.02}, Eigen::Vector3d(1, 1, 0.01).asDiagonal());
  PlanarPose truth{-80, -1.2, 0.02};
  std::vector<GridSamples> views;
  for (uint64_t i = 0; i < 24; ++i) {
    views.push_back(town::sample_view(town.map, truth = truth.compose({2, 0, 0}), i, i > 15));
    // Every second view is smaller.
    if (i % 2 == 0) continue;
    GridSamples& view = views.back();
    const GridSamples whole = view;
    view.x.resize(400);
    view.y.resize(400);
    view.features.resize(400, 3);
    for (Eigen::Index f = 0; f < 3; ++f) {
      for (Eigen::Index k = 0; k < 400; ++k) view.features(k, f) = whole.features(k, f);
    }
  }
  int states[3] = {0, 0, 0};
  for (size_t i = 0; i < views.size(); ++i) {
    const int before = counted;
    {
      const Counting count;
      tracker.predict({2, 0, 0}, Eigen::Matrix3d::Zero(), Duration(250'000'000));
      tracker.update(views[i]);
      ++states[static_cast<int>(tracker.estimate().state)];
    }
    if (i >= 2) {
      EXPECT_EQ(counted - before, 0) << i;
    }
  }
  EXPECT_GT(states[static_cast<int>(TrackState::kTracking)], 2);
}

}  // namespace
}  // namespace infuse::streetmap

#endif
