#include "fusion/monitoring/scene_store.hpp"

#include <gtest/gtest.h>

namespace infuse::monitoring {
namespace {

/// Grey image and three returns of which two lie in or around the view.
struct TestScene {
  CameraFrame grey;
  Sweep sweep;
  MonitorPoints points;
};

TestScene make_test_scene(double seconds, uint8_t level = 100) {
  TestScene shot;
  shot.grey.width = 64;
  shot.grey.height = 48;
  shot.grey.pixels.assign(64 * 48, level);
  shot.grey.stamp = Stamp::from_ns(static_cast<int64_t>(seconds * 1e9));
  shot.sweep.resize(3);
  const std::array<float, 3> x = {5, 10, -5};
  for (size_t i = 0; i < 3; ++i) {
    shot.sweep.x[i] = x[i];
    shot.sweep.y[i] = shot.sweep.z[i] = 0;
    shot.sweep.range[i] = std::abs(x[i]);
    shot.sweep.reflectivity[i] = 0.1F * static_cast<float>(i + 1);
    shot.sweep.ring[i] = static_cast<uint16_t>(i);
    shot.sweep.column[i] = 0;
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  shot.points.select(
      make_sweep_view(shot.sweep),
      geometry::CameraModel({.width = 64, .height = 48, .fx = 50, .fy = 50, .cx = 32, .cy = 24}), T,
      100);
  return shot;
}

bool offer(SceneStore& store, double seconds, double worth, double rate = 0, uint8_t level = 100) {
  const TestScene shot = make_test_scene(seconds, level);
  return store.offer(shot.grey, make_sweep_view(shot.sweep), shot.points, worth, 10 * seconds,
                     rate);
}

std::vector<double> stored_seconds(SceneStore& store) {
  std::vector<double> seconds;
  for (const StoredScene* scene : store.lend(Stamp::earliest())) {
    seconds.push_back(static_cast<double>(scene->stamp.ns()) * 1e-9);
  }
  store.end_lending();
  return seconds;
}

TEST(SceneStore, KeepsTheMostInformativeAndRemovesTheOld) {
  SceneStore store({.capacity = 3, .half_life = 10, .max_age = 100});
  EXPECT_TRUE(offer(store, 1, 0.5));
  EXPECT_TRUE(offer(store, 2, 0.9));
  EXPECT_TRUE(offer(store, 3, 0.6));
  EXPECT_FALSE(offer(store, 4, 0.1));  // less informative than any
  EXPECT_TRUE(offer(store, 5, 0.55));  // replaces the first
  EXPECT_EQ(stored_seconds(store), (std::vector<double>{2, 3, 5}));
  EXPECT_TRUE(offer(store, 50, 0.1));  // old scenes count little
  EXPECT_EQ(store.size(), 3U);
  EXPECT_EQ(store.count_since(Stamp::from_ns(6'000'000'000)), 1U);
  EXPECT_TRUE(offer(store, 300, 0.1));
  EXPECT_EQ(stored_seconds(store), (std::vector<double>{300}));
}

TEST(SceneStore, RejectsUninformativeScenes) {
  SceneStore store({.capacity = 3, .min_distance = 4});
  EXPECT_FALSE(offer(store, 1, 0));
  EXPECT_FALSE(offer(store, 1, 0.5, 1.0));     // turning fast
  EXPECT_FALSE(offer(store, 1, 0.5, 0, 5));    // dark
  EXPECT_FALSE(offer(store, 1, 0.5, 0, 250));  // over-exposed
  EXPECT_TRUE(offer(store, 1, 0.5));
  EXPECT_FALSE(offer(store, 1.3, 0.9));  // 3 m farther only
  EXPECT_EQ(store.size(), 1U);
}

TEST(SceneStore, KeepsPointsAroundTheImage) {
  SceneStore store({.capacity = 3});
  ASSERT_TRUE(offer(store, 1, 0.5));
  const auto scenes = store.lend(Stamp::earliest());
  ASSERT_EQ(scenes.size(), 1U);
  EXPECT_EQ(scenes[0]->x, (std::vector<float>{5, 10}));
  EXPECT_EQ(scenes[0]->reflectivity, (std::vector<float>{0.5F, 0.5F}));  // each alone in its group
  EXPECT_EQ(scenes[0]->grey.pixels.size(), 64U * 48U);
}

TEST(SceneStore, LentScenesStayAsTheyAre) {
  SceneStore store({.capacity = 3});
  for (int k = 1; k <= 3; ++k) ASSERT_TRUE(offer(store, k, 0.1 * k));
  const auto lent = store.lend(Stamp::from_ns(2'000'000'000));
  ASSERT_EQ(lent.size(), 2U);
  EXPECT_TRUE(offer(store, 4, 0.9));   // in the place of the one that is not lent
  EXPECT_TRUE(offer(store, 5, 0.95));  // again
  store.remove_before(Stamp::from_ns(6'000'000'000));
  EXPECT_EQ(store.size(), 2U);
  EXPECT_EQ(lent[0]->information, 0.2);
  EXPECT_EQ(lent[1]->information, 0.1 * 3);
  store.end_lending();
  store.remove_before(Stamp::from_ns(6'000'000'000));
  EXPECT_EQ(store.size(), 0U);
}

TEST(SceneStore, LargeImagesAreReduced) {
  SceneStore store({.capacity = 3, .max_pixels = 64 * 48 / 5});
  ASSERT_TRUE(offer(store, 1, 0.5, 0, 77));
  const auto scenes = store.lend(Stamp::earliest());
  EXPECT_EQ(scenes[0]->step, 3);
  EXPECT_EQ(scenes[0]->grey.width, 21);
  EXPECT_EQ(scenes[0]->grey.height, 16);
  EXPECT_EQ(scenes[0]->grey.pixels, std::vector<uint8_t>(21 * 16, 77));
}

TEST(SceneStoreOptions, SaysWhatIsWrong) {
  EXPECT_FALSE(SceneStoreOptions{}.invalid());
  EXPECT_TRUE(SceneStoreOptions{.capacity = 1}.invalid());
  EXPECT_TRUE((SceneStoreOptions{.min_mean_grey = 100, .max_mean_grey = 50}.invalid()));
}

}  // namespace
}  // namespace infuse::monitoring
