// The search of all streets by the drive alone: on maps of up to 300 km², and on one where two
// places look alike.
#include <malloc.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <numbers>

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

/// Odometry of a drive, with lasting errors.
class Odometry {
 public:
  explicit Odometry(uint64_t seed) : random_(seed) {
    scale_ = 1 + 0.006 * normal_(random_);
    rate_ = 0.001 * normal_(random_);
  }

  void move(GlobalStart& start, const PlanarPose& from, const PlanarPose& to) {
    const double seconds = kStep / kSpeed;
    PlanarPose motion = from.motion_to(to);
    motion.x = scale_ * motion.x + 0.01 * normal_(random_);
    motion.yaw += rate_ * seconds + 3e-4 * normal_(random_);
    start.move(motion, Eigen::Vector3d(1e-4, 1e-4, 1e-7).asDiagonal(), seconds);
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  double scale_ = 1, rate_ = 0;
};

LargeRun search(GlobalStart& start, const std::vector<PlanarPose>& drive, uint64_t seed) {
  Odometry odometry(seed);
  start.restart();
  LargeRun result;
  double first_turn = -1, second_began = cpu_seconds();
  const double began = second_began;
  for (size_t i = 1; i < drive.size(); ++i) {
    odometry.move(start, drive[i - 1], drive[i]);
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

/// Two carriageways of 1.6 km, joined at both ends; turned by half a turn, the map is the same.
constexpr double kRoad = 1600, kBetween = 24;  // m

StreetPlan dual_carriageway() {
  StreetPlan plan;
  const auto add = [&](const Polyline& points) {
    plan.strips.push_back({{SegmentKind::kCarriageway, 1}, points, 3.5, 0.4});
  };
  add({{0, 0}, {kRoad, 0}});
  add({{0, kBetween}, {kRoad, kBetween}});
  add({{0, 0}, {0, kBetween}});
  add({{kRoad, 0}, {kRoad, kBetween}});
  return plan;
}

/// East from `begin` (m), a turn to the other carriageway, and back.
std::vector<PlanarPose> drive_and_return(double begin) {
  constexpr double kRadius = kBetween / 2;
  std::vector<PlanarPose> poses{{begin, 0, 0}};
  while (poses.back().x < kRoad - kRadius) poses.push_back(poses.back().compose({kStep, 0, 0}));
  while (wrap_angle(poses.back().yaw) >= 0) {
    poses.push_back(poses.back().compose({kStep, 0, kStep / kRadius}));
  }
  poses.back().yaw = -std::numbers::pi;
  while (poses.back().x > kRoad / 4) poses.push_back(poses.back().compose({kStep, 0, 0}));
  return poses;
}

struct AlikeRun {
  double after = -1;  // m driven until two places are named, one of which is true; below 0: never
  double probability = 0;  // of that one then
  bool sure = false;       // of one alone, ever
};

AlikeRun name_places(GlobalStart& start, double begin, uint64_t seed) {
  const std::vector<PlanarPose> drive = drive_and_return(begin);
  Odometry odometry(seed);
  start.restart();
  AlikeRun result;
  for (size_t i = 1; i < drive.size(); ++i) {
    odometry.move(start, drive[i - 1], drive[i]);
    if (i % 10 != 0) continue;
    const auto place = start.place();
    result.sure = result.sure || (place && place->sure);
    const PossiblePlaces places = start.possible_places();
    double named = 0;
    double here = 0;
    for (const PossiblePlace& one : places.all()) {
      named += one.probability;
      if (is_same_place(one.pose, drive[i], kFound)) here = one.probability;
    }
    if (result.after >= 0 || places.all().size() != 2 || named < 0.9 || here == 0) continue;
    result.after = kStep * static_cast<double>(i);
    result.probability = here;
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

bool alike_streets(std::ostream& out, int drives) {
  out << "Two carriageways of 1.6 km, 24 m apart, joined at both ends, alike when turned by half a "
         "turn; by the drive alone.\n\"Named\": two places, together above 90 %, one of them "
         "within "
         "12 m of the truth.\n\n"
      << "| drives | named | after, m: median, most | probability of the true one | "
         "sure "
         "of one |\n|---|---|---|---|---|\n";
  const std::vector<std::byte> bytes = rasterise(dual_carriageway(), {}, "road").value();
  const auto map = SegmentMap::open(bytes, "road");
  if (!map) return false;
  GlobalStart start(*map, {});
  std::vector<double> after;
  double low = 1, high = 0;
  int sure = 0;
  for (int i = 0; i < drives; ++i) {
    const double begin = kRoad / 4 + kRoad / 2 * (i + 0.5) / drives;
    const AlikeRun run = name_places(start, begin, kFirstDrive + static_cast<uint64_t>(i));
    if (run.after >= 0) after.push_back(run.after);
    low = std::min(low, run.probability);
    high = std::max(high, run.probability);
    sure += run.sure;
  }
  std::sort(after.begin(), after.end());
  const std::string row =
      format_text("| %d | %zu | %.0f, %.0f | %.0f to %.0f %% | %d |\n", drives, after.size(),
                  after.empty() ? 0.0 : after[after.size() / 2], after.empty() ? 0.0 : after.back(),
                  100 * low, 100 * high, sure);
  out << row;
  std::fputs(row.c_str(), stderr);
  return true;
}

}  // namespace infuse::streetmap::bench
