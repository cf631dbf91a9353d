#include <benchmark/benchmark.h>

#include <cmath>

#include "fusion/motion/deskew.hpp"

namespace infuse {
namespace {

constexpr size_t kReturns = 130'000;  // HDL-64E, 10 Hz
constexpr int64_t kSpanNs = 100'000'000;

/// 15 m/s, 30°/s to the left, one pose every 10 ms.
geometry::Trajectory trajectory() {
  geometry::Trajectory drive;
  geometry::Vector6 step;
  step << 0, 0, 0.5236 * 0.01, 15 * 0.01, 0, 0;
  geometry::StampedPose pose;
  for (int i = -2; i <= 14; ++i) {
    pose.stamp = Stamp::from_ns(i * 10'000'000);
    drive.append(pose);
    pose.T_odom_vehicle = pose.T_odom_vehicle * geometry::exp(step);
  }
  return drive;
}

Sweep sweep() {
  Sweep made;
  made.resize(kReturns);
  made.span = Duration(kSpanNs);
  for (size_t i = 0; i < kReturns; ++i) {
    const double part = static_cast<double>(i) / kReturns;
    const double range = 5 + 60 * std::abs(std::sin(37 * part));
    made.x[i] = static_cast<float>(range * std::cos(6.28 * part));
    made.y[i] = static_cast<float>(range * std::sin(6.28 * part));
    made.z[i] = static_cast<float>(static_cast<int>(i % 64) - 50) * 0.03f;
    made.time_offset_ns[i] = static_cast<int32_t>(static_cast<int64_t>(i / 64 * 64) * kSpanNs /
                                                  static_cast<int64_t>(kReturns));
  }
  return made;
}

void deskew(benchmark::State& state) {
  const Sweep input = sweep();
  const geometry::Trajectory drive = trajectory();
  motion::Deskewer compensator(Eigen::Isometry3d::Identity());
  motion::DeskewedSweep deskewed;
  for (auto _ : state) {
    compensator.deskew(input, drive, input.stamp + input.span, deskewed);
    if (!deskewed.usable()) state.SkipWithError(deskewed.reason);
    benchmark::DoNotOptimize(deskewed.x.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(kReturns));
}

/// Computes the twist of each segment once, then an exp for every point; segments are found
/// sequentially.
void per_point_exp(benchmark::State& state) {
  const Sweep input = sweep();
  const geometry::Trajectory drive = trajectory();
  motion::DeskewedSweep deskewed;
  deskewed.x.resize(kReturns);
  deskewed.y.resize(kReturns);
  deskewed.z.resize(kReturns);
  const Eigen::Isometry3d T_reference_map =
      drive.at(input.stamp + input.span).T_odom_vehicle.inverse();
  for (auto _ : state) {
    size_t piece = 0;
    geometry::Vector6 twist = geometry::Vector6::Zero();
    Eigen::Isometry3d T_reference_start;
    int64_t begin = 0, end = -1;
    for (size_t i = 0; i < kReturns; ++i) {
      const int64_t at = input.time_offset_ns[i];
      while (at > end) {
        const geometry::StampedPose &a = drive[piece], &b = drive[piece + 1];
        begin = a.stamp.ns();
        end = b.stamp.ns();
        twist = geometry::log(a.T_odom_vehicle.inverse() * b.T_odom_vehicle) /
                static_cast<double>(end - begin);
        T_reference_start = T_reference_map * a.T_odom_vehicle;
        ++piece;
      }
      const Eigen::Vector3d moved =
          T_reference_start * (geometry::exp(static_cast<double>(at - begin) * twist) *
                               Eigen::Vector3d(input.x[i], input.y[i], input.z[i]));
      deskewed.x[i] = static_cast<float>(moved.x());
      deskewed.y[i] = static_cast<float>(moved.y());
      deskewed.z[i] = static_cast<float>(moved.z());
    }
    benchmark::DoNotOptimize(deskewed.x.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(kReturns));
}

BENCHMARK(deskew)->Name("motion/deskew");
BENCHMARK(per_point_exp)->Name("motion/deskew/baseline:per_point_exp");

}  // namespace
}  // namespace infuse
