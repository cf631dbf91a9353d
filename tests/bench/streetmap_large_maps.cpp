// The search of all streets on maps of up to 300 km².
#include <malloc.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>

#include "fusion/streetmap/global_start.hpp"
#include "fusion/streetmap/rasterise.hpp"
#include "tests/bench/irregular_town.hpp"
#include "tests/bench/streetmap_sections.hpp"

namespace infuse::streetmap::bench {
namespace {

constexpr double kStep = 1, kSpeed = 10;              // m, m/s
constexpr double kLength = 4000;                      // m
constexpr uint64_t kTownSeed = 8, kFirstDrive = 101;  // settings were chosen on 7, from 1
constexpr double kFound = 12;                         // m, of the truth
constexpr double kTurned = 0.7, kTurnLength = 30;     // rad, m

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Begins to measure the peak of this process's memory anew.
void reset_peak() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";
}

/// MB.
double peak_memory() {
  std::ifstream status("/proc/self/status");
  std::string word;
  double kilobytes = 0;
  while (status >> word) {
    if (word == "VmHWM:") status >> kilobytes;
  }
  return kilobytes / 1e3;
}

struct LargeRun {
  double after_turn = -1, after = -1;  // m driven until the place is sure; below 0: never
  bool right = false;
  double busiest = 0, load = 0;  // processor time, s per s of a second, of all until then
};

bool turned(const std::vector<PlanarPose>& drive, size_t at) {
  const size_t before = at - std::min(at, static_cast<size_t>(kTurnLength / kStep));
  return std::abs(wrap_angle(drive[at].yaw - drive[before].yaw)) > kTurned;
}

LargeRun search(GlobalStart& start, const std::vector<PlanarPose>& drive, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const double scale = 1 + 0.006 * normal(random), rate = 0.001 * normal(random);
  const double seconds = kStep / kSpeed;
  const Eigen::Matrix3d noise = Eigen::Vector3d(1e-4, 1e-4, 1e-7).asDiagonal();
  start.restart();
  LargeRun result;
  double first_turn = -1, second_began = cpu_seconds();
  const double began = second_began;
  for (size_t i = 1; i < drive.size(); ++i) {
    PlanarPose motion = drive[i - 1].motion_to(drive[i]);
    motion.x = scale * motion.x + 0.01 * normal(random);
    motion.yaw += rate * seconds + 3e-4 * normal(random);
    start.move(motion, noise, seconds);
    const double driven = kStep * static_cast<double>(i);
    if (first_turn < 0 && turned(drive, i)) first_turn = driven;
    if (i % static_cast<size_t>(kSpeed / kStep) != 0) continue;
    const auto place = start.place();
    const double now = cpu_seconds();
    result.busiest = std::max(result.busiest, now - second_began);
    result.load = (now - began) * kSpeed / driven;
    second_began = now;
    if (!place || !place->sure) continue;
    result.after = driven;
    result.after_turn = driven - first_turn;
    result.right = std::hypot(place->pose.x - drive[i].x, place->pose.y - drive[i].y) < kFound;
    break;
  }
  return result;
}

}  // namespace

bool large_maps(std::ostream& out, int drives) {
  out << "Irregular towns with 170 streets per km², driven at 10 m/s with turns at half of the "
         "crossings; by the drive alone.\n\n"
      << "| map, km² | file, MB | drives | found | median after the first turn, m | most, m | sure "
         "of "
         "a wrong place | memory, MB | to begin, s | load | busiest second |\n"
         "|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const double area : {1.0, 10.0, 30.0, 100.0, 300.0}) {
    const IrregularTown town(area * 1e6, kTownSeed);
    DriveMap made;
    if (auto bytes = rasterise(town.plan(), {}, "town")) made.bytes = std::move(*bytes);
    const auto map = SegmentMap::open(made.bytes, "town");
    if (!map) return false;
    reset_peak();
    const double began = cpu_seconds();
    GlobalStart start(*map, {});
    const double begin = cpu_seconds() - began;
    std::vector<double> after;
    int wrong = 0;
    double load = 0, busiest = 0;
    for (int i = 0; i < drives; ++i) {
      const auto seed = kFirstDrive + static_cast<uint64_t>(i);
      const LargeRun run = search(start, town.drive(kLength, kStep, seed), seed);
      if (std::getenv("INFUSE_BENCH_VERBOSE") != nullptr) {
        std::fprintf(stderr,
                     "%.0f km², drive %d: %s after %.0f m, %.0f after the turn, load %.2f\n", area,
                     i, run.right ? "right" : "wrong", run.after, run.after_turn, run.load);
      }
      load = std::max(load, run.load);
      busiest = std::max(busiest, run.busiest);
      wrong += run.after >= 0 && !run.right;
      if (run.right) after.push_back(run.after_turn);
    }
    std::sort(after.begin(), after.end());
    const auto found = static_cast<int>(after.size());
    const std::string row =
        format_text("| %.0f | %.1f | %d | %d | %.0f | %.0f | %d | %.0f | %.1f | %.2f | %.2f |\n",
                    area, static_cast<double>(made.bytes.size()) / 1e6, drives, found,
                    found > 0 ? after[after.size() / 2] : 0.0, found > 0 ? after.back() : 0.0,
                    wrong, peak_memory(), begin, load, busiest);
    out << row << std::flush;
    std::fputs(row.c_str(), stderr);
  }
  return true;
}

}  // namespace infuse::streetmap::bench
