#include <gtest/gtest.h>

#include <cstring>

#include "drivers/import/bag_cloud.hpp"

namespace infuse::importers {
namespace {

using ros::PointField;

constexpr int64_t kStart = 1'700'000'000'000'000'000;

/// Clouds of four rings and ninety columns around the lidar, in the layout of a maker's driver.
class CloudMaker {
 public:
  CloudMaker(std::vector<PointField> fields, uint32_t step) : step_(step) {
    cloud_.point_fields = std::move(fields);
    cloud_.point_step = step;
    cloud_.height = 1;
  }

  template <class Value>
  void set(size_t point, const std::string& field, Value value) {
    for (const PointField& f : cloud_.point_fields) {
      if (f.name == field) std::memcpy(&data_[point * step_ + f.offset], &value, sizeof value);
    }
  }

  /// Fills positions and rings; `set_time(point, column)` sets the times.
  template <class SetTime>
  ros::PointCloud2& make(SetTime set_time) {
    constexpr size_t kRings = 4, kColumns = 90;
    cloud_.width = kRings * kColumns;
    cloud_.row_step = cloud_.width * step_;
    data_.assign(cloud_.row_step, 0xEE);
    for (size_t column = 0; column < kColumns; ++column) {
      for (size_t ring = 0; ring < kRings; ++ring) {
        const size_t point = column * kRings + ring;
        const double azimuth = -0.07 * static_cast<double>(column);
        set(point, "x", static_cast<float>(10 * std::cos(azimuth)));
        set(point, "y", static_cast<float>(10 * std::sin(azimuth)));
        set(point, "z", static_cast<float>(ring) - 1.5f);
        set(point, "intensity", 0.25f);
        set(point, "ring", static_cast<uint16_t>(ring));
        set_time(point, column);
      }
    }
    cloud_.data = data_;
    return cloud_;
  }

 private:
  ros::PointCloud2 cloud_;
  uint32_t step_;
  std::vector<uint8_t> data_;
};

std::vector<PointField> fields_with(const PointField& time) {
  return {{"x", 0, PointField::kFloat32, 1},    {"y", 4, PointField::kFloat32, 1},
          {"z", 8, PointField::kFloat32, 1},    {"intensity", 16, PointField::kFloat32, 1},
          {"ring", 20, PointField::kUint16, 1}, time};
}

/// The time of each return follows from its azimuth: column k has k ms.
void expect_times(const Sweep& sweep, double tolerance_ns) {
  ASSERT_EQ(sweep.size(), 360u);
  ASSERT_TRUE(sweep.has_times);
  EXPECT_EQ(sweep.rings, 4);
  for (size_t i = 0; i < sweep.size(); ++i) {
    double turned = -std::atan2(sweep.y[i], sweep.x[i]);
    if (turned < -1e-3) turned += 2 * M_PI;
    const double expected = std::round(turned / 0.07) * 1e6;
    EXPECT_NEAR(sweep.time_offset_ns[i], expected, tolerance_ns);
    EXPECT_NEAR(sweep.z[i], sweep.ring[i] - 1.5, 1e-6);
    EXPECT_FLOAT_EQ(sweep.reflectivity[i], 0.25f);
  }
}

TEST(BagCloud, OusterNanosecondsAfterTheHeader) {
  CloudMaker maker(fields_with({"t", 24, PointField::kUint32, 1}), 48);
  const auto& cloud = maker.make(
      [&](size_t i, size_t k) { maker.set(i, "t", static_cast<uint32_t>(k * 1'000'000)); });
  Sweep sweep;
  ASSERT_TRUE(to_sweep(cloud, Stamp::from_ns(kStart), sweep));
  expect_times(sweep, 0);
  EXPECT_EQ(sweep.stamp.ns(), kStart);
  EXPECT_EQ(sweep.span.count(), 89'000'000);
}

TEST(BagCloud, VelodyneSecondsBeforeTheHeader) {
  CloudMaker maker(fields_with({"time", 24, PointField::kFloat32, 1}), 28);
  const auto& cloud = maker.make(
      [&](size_t i, size_t k) { maker.set(i, "time", 0.001f * static_cast<float>(k) - 0.089f); });
  Sweep sweep;
  ASSERT_TRUE(to_sweep(cloud, Stamp::from_ns(kStart), sweep));
  expect_times(sweep, 20);
  EXPECT_NEAR(static_cast<double>(sweep.stamp.ns() - kStart), -89e6, 20);
}

TEST(BagCloud, HesaiAbsoluteSeconds) {
  CloudMaker maker(fields_with({"timestamp", 24, PointField::kFloat64, 1}), 32);
  const auto& cloud = maker.make([&](size_t i, size_t k) {
    maker.set(i, "timestamp", 1'700'000'000.0 + 0.001 * static_cast<double>(k));
  });
  Sweep sweep;
  ASSERT_TRUE(to_sweep(cloud, Stamp(), sweep));
  expect_times(sweep, 500);
  EXPECT_NEAR(static_cast<double>(sweep.stamp.ns() - kStart), 0, 500);
}

TEST(BagCloud, LivoxAbsoluteNanosecondsInDoubles) {
  CloudMaker maker(fields_with({"timestamp", 24, PointField::kFloat64, 1}), 32);
  const auto& cloud = maker.make([&](size_t i, size_t k) {
    maker.set(i, "timestamp", 1.7e18 + 1e6 * static_cast<double>(k));
  });
  Sweep sweep;
  ASSERT_TRUE(to_sweep(cloud, Stamp(), sweep));
  expect_times(sweep, 500);
  EXPECT_NEAR(static_cast<double>(sweep.stamp.ns() - kStart), 0, 500);
}

TEST(BagCloud, WithoutTimesTheSweepHasNone) {
  CloudMaker maker(fields_with({"tag", 24, PointField::kUint8, 1}), 32);
  const auto& cloud = maker.make([](size_t, size_t) {});
  Sweep sweep;
  ASSERT_TRUE(to_sweep(cloud, Stamp::from_ns(kStart), sweep));
  EXPECT_FALSE(sweep.has_times);
  EXPECT_EQ(sweep.stamp.ns(), kStart);
}

TEST(BagCloud, EqualTimesAreNone) {
  CloudMaker maker(fields_with({"t", 24, PointField::kUint32, 1}), 32);
  const auto& cloud = maker.make([&](size_t i, size_t) { maker.set(i, "t", 0u); });
  Sweep sweep;
  ASSERT_TRUE(to_sweep(cloud, Stamp::from_ns(kStart), sweep));
  EXPECT_FALSE(sweep.has_times);
}

TEST(BagCloud, LayoutsThatContradictTheDataAreErrors) {
  CloudMaker maker(fields_with({"t", 24, PointField::kUint32, 1}), 32);
  const ros::PointCloud2 sound = maker.make([&](size_t i, size_t) { maker.set(i, "t", 0u); });
  Sweep sweep;
  const auto refused = [&](auto change) {
    ros::PointCloud2 cloud = sound;
    change(cloud);
    return !to_sweep(cloud, Stamp(), sweep);
  };
  EXPECT_FALSE(refused([](auto&) {}));
  EXPECT_TRUE(refused([](auto& cloud) { cloud.is_bigendian = true; }));
  EXPECT_TRUE(refused([](auto& cloud) { cloud.width = 361; }));
  EXPECT_TRUE(refused([](auto& cloud) { cloud.width = cloud.height = 0xFFFFFFFF; }));
  EXPECT_TRUE(refused([](auto& cloud) { cloud.point_step = 26; }));
  EXPECT_TRUE(refused([](auto& cloud) { cloud.point_fields[1].offset = 2; }));
  EXPECT_TRUE(refused([](auto& cloud) { cloud.point_fields[1].offset = 0xFFFFFFFF; }));
  EXPECT_TRUE(refused([](auto& cloud) { cloud.point_fields[5].count = 0xFFFFFFFF; }));
  EXPECT_TRUE(refused([](auto& cloud) { cloud.point_fields[0].datatype = 9; }));
  EXPECT_TRUE(refused([](auto& cloud) { cloud.point_fields[0].name = "a"; }));
  EXPECT_TRUE(refused([](auto& cloud) { cloud.height = 2, cloud.row_step = 1; }));
}

TEST(BagCloud, TimesThatSpanMoreThanATurnAreErrors) {
  CloudMaker maker(fields_with({"t", 24, PointField::kUint32, 1}), 32);
  const auto& cloud = maker.make(
      [&](size_t i, size_t k) { maker.set(i, "t", static_cast<uint32_t>(k * 40'000'000)); });
  Sweep sweep;
  EXPECT_FALSE(to_sweep(cloud, Stamp(), sweep));
}

}  // namespace
}  // namespace infuse::importers
