#include "tests/study/registration/global_guess_study.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <numbers>
#include <stdexcept>

#include "drivers/measurement/angles.hpp"
#include "fixtures/simulator/world/random.hpp"
#include "fusion/registration/global_guess.hpp"
#include "tests/study/registration/rendered_drive.hpp"

namespace infuse::study {
namespace {

constexpr double kNearest = 1, kFarthest = 10;  // m, between the scans of a pair

/// The sweep in a lidar frame that is turned about z.
Sweep turned(Sweep sweep, const Eigen::Isometry3f& T_new_old) {
  for (size_t i = 0; i < sweep.size(); ++i) {
    const Eigen::Vector3f p = T_new_old * Eigen::Vector3f(sweep.x[i], sweep.y[i], sweep.z[i]);
    sweep.x[i] = p.x();
    sweep.y[i] = p.y();
    sweep.z[i] = p.z();
  }
  return sweep;
}

}  // namespace

void GlobalGuessShare::operator+=(const GlobalGuessShare& other) {
  pairs += other.pairs;
  right += other.right;
  wrong += other.wrong;
  max_distance = std::max(max_distance, other.max_distance);
}

std::string GlobalGuessShare::text() const {
  return fmt::format(
      "{} of {} pairs right ({:.1f} %), {} usable but wrong; up to {:.1f} m apart", right, pairs,
      100 * static_cast<double>(right) / static_cast<double>(std::max<size_t>(pairs, 1)), wrong,
      max_distance);
}

GlobalGuessShare try_global_guess(std::span<const PosedScan> scans, size_t count, uint64_t seed) {
  struct Pair {
    double order;
    size_t target, source;
  };
  const simulator::Random random(seed, "global guess");
  std::vector<Pair> pairs;
  for (size_t t = 0; t < scans.size(); ++t) {
    for (size_t s = 0; s < scans.size(); ++s) {
      const double distance =
          (scans[t].T_world_lidar.inverse() * scans[s].T_world_lidar).translation().norm();
      if (distance < kNearest || distance > kFarthest) continue;
      pairs.push_back({random.uniform(2 * (t * scans.size() + s)), t, s});
    }
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const Pair& a, const Pair& b) { return a.order < b.order; });
  pairs.resize(std::min(pairs.size(), count));
  GlobalGuessShare share;
  for (const auto& [order, t, s] : pairs) {
    const double heading =
        random.uniform(2 * (t * scans.size() + s) + 1, -std::numbers::pi, std::numbers::pi);
    const Eigen::Isometry3d T_new_old(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()));
    const Sweep& target = scans[t].sweep;
    const Sweep source = turned(scans[s].sweep, T_new_old.cast<float>());
    const Eigen::Isometry3d T_target_old =
        scans[t].T_world_lidar.inverse() * scans[s].T_world_lidar;
    const auto found = registration::find_global_guess({target.x, target.y, target.z},
                                                       {source.x, source.y, source.z});
    const Eigen::Isometry3d error = found.T_target_source * T_new_old * T_target_old.inverse();
    const bool near =
        (found.T_target_source.translation() - T_target_old.translation()).norm() < 0.5 &&
        geometry::rotation_log(error.linear()).norm() < 2 * kDegree;
    ++share.pairs;
    share.right += found.usable() && near;
    share.wrong += found.usable() && !near;
    share.max_distance = std::max(share.max_distance, T_target_old.translation().norm());
  }
  return share;
}

GlobalGuessShare try_global_guess_simulated(uint64_t first_seed, int drives) {
  GlobalGuessShare share;
  for (int d = 0; d < drives; ++d) {
    const uint64_t seed = first_seed + static_cast<uint64_t>(d);
    const auto drive = render_drive(seed, {0, 2.2, 4.6, 7.2, 9.9}, {.images = false});
    if (!drive) throw std::runtime_error(drive.error().message());
    share += try_global_guess(drive->scans, 10, seed);
  }
  return share;
}

}  // namespace infuse::study
