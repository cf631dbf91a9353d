// GICP on real sweeps of an HDL-64E (INFUSE_REAL_DATA): KITTI odometry 00, sweeps 94 → 95 from the
// identity, and the fifty neighbours of KITTI raw 0009, as measured. small_gicp, where its sources
// are (INFUSE_PEERS), has the same points, voxel size, neighbours and tolerances, one thread, and
// all instructions of this processor. `error_mm` is the distance from the published pose,
// `apart_mm` that between the two results.

#include <benchmark/benchmark.h>

#include <spdlog/fmt/fmt.h>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "fusion/registration/gicp.hpp"
#include "tests/fusion/registration/random_room.hpp"
#ifdef INFUSE_PEER_SMALL_GICP
#include "tests/bench/peer_small_gicp.hpp"
#endif

namespace infuse::registration {
namespace {

constexpr double kVoxelSize = 0.25;  // m
constexpr int kNeighbours = 10;

/// Neighbouring sweeps, and the published pose of the second in the frame of the first.
struct SweepPair {
  PointCloud target, source;
};

std::filesystem::path data() {
  const char* root = std::getenv("INFUSE_REAL_DATA");
  return root == nullptr ? "" : root;
}

PointCloud read_sweep(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(stream)), {});
  PointCloud cloud;
  cloud.resize(bytes.size() / 16);
  for (size_t i = 0; i < cloud.size(); ++i) {
    float point[3];
    std::memcpy(point, &bytes[16 * i], sizeof(point));
    cloud.x[i] = point[0], cloud.y[i] = point[1], cloud.z[i] = point[2];
  }
  return cloud;
}

std::vector<SweepPair> read_pairs(bool whole_drive) {
  std::vector<SweepPair> pairs;
  if (!whole_drive) {
    const auto folder = data() / "registration/kitti_odometry_00/velodyne";
    pairs.push_back({read_sweep(folder / "000094.bin"), read_sweep(folder / "000095.bin")});
    return pairs;
  }
  const auto folder = data() /
                      "drives/kitti_raw_0009/2011_09_26/2011_09_26_drive_0009_sync/velodyne_points/"
                      "data";
  for (int k = 0; k < 50; ++k) {
    pairs.push_back({read_sweep(folder / fmt::format("{:010}.bin", k)),
                     read_sweep(folder / fmt::format("{:010}.bin", k + 1))});
  }
  return pairs;
}

/// Skips the benchmark without real sweeps.
bool absent(benchmark::State& state, const std::vector<SweepPair>& pairs) {
  if (pairs.front().target.size() > 0) return false;
  state.SkipWithError("no KITTI sweeps under INFUSE_REAL_DATA");
  return true;
}

const PrepareOptions& prepare_options() {
  static const PrepareOptions options{.voxel_size = kVoxelSize,
                                      .covariance = {.neighbours = kNeighbours}};
  return options;
}

void prepare(benchmark::State& state, bool whole_drive) {
  const auto pairs = read_pairs(whole_drive);
  if (absent(state, pairs)) return;
  CloudPreparer preparer;
  PreparedCloud out;
  for (auto _ : state) {
    for (const SweepPair& pair : pairs)
      preparer.prepare(pair.source.points(), prepare_options(), out);
  }
  state.counters["points"] = static_cast<double>(out.cloud.size());
}

void align(benchmark::State& state, bool whole_drive) {
  const auto pairs = read_pairs(whole_drive);
  if (absent(state, pairs)) return;
  CloudPreparer preparer;
  Gicp gicp;
  PreparedCloud target, source;
  double iterations = 0, apart = 0, count = 0;
  for (auto _ : state) {
    iterations = apart = count = 0;
    for (const SweepPair& pair : pairs) {
      state.PauseTiming();
      preparer.prepare(pair.target.points(), prepare_options(), target);
      preparer.prepare(pair.source.points(), prepare_options(), source);
      state.ResumeTiming();
      const RegistrationResult result =
          gicp.align(target, source.cloud, Eigen::Isometry3d::Identity());
      iterations += result.iterations;
      ++count;
    }
  }
  state.counters["iterations"] = iterations / count;
#ifdef INFUSE_PEER_SMALL_GICP
  // Both from the same optimum on, so that only the tolerances are between them.
  for (const SweepPair& pair : pairs) {
    bench::PeerSmallGicp peer;
    peer.set_points(0, pair.target.points());
    peer.set_points(1, pair.source.points());
    for (const int which : {0, 1}) peer.prepare(which, kVoxelSize, kNeighbours);
    preparer.prepare(pair.target.points(), prepare_options(), target);
    preparer.prepare(pair.source.points(), prepare_options(), source);
    Eigen::Matrix4d theirs;
    const Eigen::Matrix4d identity = Eigen::Matrix4d::Identity();
    peer.align(identity.data(), RegistrationOptions().max_correspondence_distance, theirs.data());
    const RegistrationResult result =
        gicp.align(target, source.cloud, Eigen::Isometry3d::Identity());
    apart = std::max(apart,
                     (theirs.topRightCorner<3, 1>() - result.T_target_source.translation()).norm());
  }
  state.counters["max_apart_mm"] = 1000 * apart;
#endif
}

#ifdef INFUSE_PEER_SMALL_GICP
void prepare_small_gicp(benchmark::State& state, bool whole_drive) {
  const auto pairs = read_pairs(whole_drive);
  if (absent(state, pairs)) return;
  bench::PeerSmallGicp peer;
  size_t points = 0;
  for (auto _ : state) {
    for (const SweepPair& pair : pairs) {
      state.PauseTiming();
      peer.set_points(1, pair.source.points());
      state.ResumeTiming();
      points = peer.prepare(1, kVoxelSize, kNeighbours);
    }
  }
  state.counters["points"] = static_cast<double>(points);
}

void align_small_gicp(benchmark::State& state, bool whole_drive) {
  const auto pairs = read_pairs(whole_drive);
  if (absent(state, pairs)) return;
  bench::PeerSmallGicp peer;
  const Eigen::Matrix4d identity = Eigen::Matrix4d::Identity();
  Eigen::Matrix4d T_target_source;
  double iterations = 0, count = 0;
  for (auto _ : state) {
    iterations = count = 0;
    for (const SweepPair& pair : pairs) {
      state.PauseTiming();
      peer.set_points(0, pair.target.points());
      peer.set_points(1, pair.source.points());
      for (const int which : {0, 1}) peer.prepare(which, kVoxelSize, kNeighbours);
      state.ResumeTiming();
      iterations += static_cast<double>(
          1 + peer.align(identity.data(), RegistrationOptions().max_correspondence_distance,
                         T_target_source.data()));
      ++count;
    }
  }
  state.counters["iterations"] = iterations / count;
}
BENCHMARK_CAPTURE(prepare_small_gicp, 00, false)
    ->Name("registration/prepare/94-95/baseline:small_gicp")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(align_small_gicp, 00, false)
    ->Name("registration/gicp/94-95/baseline:small_gicp")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(prepare_small_gicp, 0009, true)
    ->Name("registration/prepare/0009/baseline:small_gicp")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(align_small_gicp, 0009, true)
    ->Name("registration/gicp/0009/baseline:small_gicp")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
#endif

/// 500 pairs of simulated rooms: squared error in units of the stated covariance, per degree of
/// freedom (1: honest).
void covariance(benchmark::State& state) {
  constexpr unsigned kPairs = 500;
  const double noise = 0.01 * static_cast<double>(state.range(0));
  const auto points = static_cast<size_t>(state.range(1));
  double sum = 0, usable = 0;
  for (auto _ : state) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    sum = usable = 0;
    for (unsigned i = 0; i < kPairs; ++i) {
      geometry::Vector6 twist;
      for (int k = 0; k < 6; ++k) twist[k] = (k < 3 ? 0.02 : 0.2) * normal(random);
      const Eigen::Isometry3d truth = geometry::exp(twist);
      const auto target = prepare_cloud(
          random_room(2 * i + 1, points, noise, Eigen::Isometry3d::Identity()).points());
      const auto source = prepare_cloud(random_room(2 * i + 2, points, noise, truth).points());
      const RegistrationResult result = gicp(target, source.cloud, Eigen::Isometry3d::Identity());
      if (!result.usable()) continue;
      const geometry::Vector6 error = geometry::log(truth * result.T_target_source.inverse());
      sum += error.dot(result.information * error) / 6;
      ++usable;
    }
  }
  state.counters["normalised_error"] = sum / usable;
  state.counters["usable_percent"] = 100 * usable / kPairs;
}
BENCHMARK(covariance)
    ->Name("registration/covariance")
    ->ArgsProduct({{1, 3}, {4000, 12000}})
    ->Iterations(1)
    ->Unit(benchmark::kSecond);

BENCHMARK_CAPTURE(prepare, 00, false)
    ->Name("registration/prepare/94-95")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(align, 00, false)->Name("registration/gicp/94-95")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(prepare, 0009, true)
    ->Name("registration/prepare/0009")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(align, 0009, true)
    ->Name("registration/gicp/0009")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace infuse::registration
