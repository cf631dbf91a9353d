#include "tests/study/starts/start_study.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <ostream>
#include <random>

#include "daemon/streetmap/street_plan_from_osm.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/osm/openstreetmap.hpp"
#include "fixtures/simulator/vehicle/trajectory.hpp"
#include "fusion/streetmap/rasterise.hpp"

namespace infuse::study {
namespace {

using streetmap::PlanarPose;

constexpr double kMark = 10;           // m
constexpr double kRightDistance = 12;  // m
constexpr double kRightYaw = 15 * kDegree;
constexpr double kChiSquared99 = 9.21;        // of two
constexpr uint64_t kForeignSeed = 1'000'000;  // between a town and the one that is driven in
constexpr double kTurn = 45 * kDegree;
constexpr double kTurnReach = 25;    // m within which a turn is driven
constexpr double kHeadingReach = 1;  // m of the line ahead and behind

/// Length of a line up to each of its points, m.
std::vector<double> lengths(const streetmap::Polyline& line) {
  std::vector<double> result{0};
  for (size_t i = 1; i < line.size(); ++i) {
    result.push_back(result.back() + (line[i] - line[i - 1]).norm());
  }
  return result;
}

/// Point of a line after `length` (m); its ends are extended.
Eigen::Vector2d point_at(const streetmap::Polyline& line, const std::vector<double>& along,
                         double length) {
  const auto after = std::lower_bound(along.begin() + 1, along.end() - 1, length);
  const auto i = static_cast<size_t>(after - along.begin());
  const double share = (length - along[i - 1]) / (along[i] - along[i - 1]);
  return line[i - 1] + share * (line[i] - line[i - 1]);
}

/// Distance driven at each pose, m.
std::vector<double> distances(const PlanarDrive& drive) {
  std::vector<double> result{0};
  for (size_t i = 1; i < drive.poses.size(); ++i) {
    const PlanarPose motion = drive.poses[i - 1].motion_to(drive.poses[i]);
    result.push_back(result.back() + std::hypot(motion.x, motion.y));
  }
  return result;
}

/// Turns of at least `kTurn` within `length` (m) from a pose on.
int count_turns(const PlanarDrive& drive, const std::vector<double>& driven, size_t first,
                double length) {
  int turns = 0;
  size_t back = first;
  for (size_t i = first; i < driven.size() && driven[i] < driven[first] + length; ++i) {
    while (driven[i] - driven[back] > kTurnReach) ++back;
    if (std::abs(wrap_angle(drive.poses[i].yaw - drive.poses[back].yaw)) < kTurn) continue;
    ++turns;
    back = i;
  }
  return turns;
}

StartMark mark_of(const streetmap::GlobalStart& start, const PlanarPose& truth, double metres) {
  StartMark mark{.metres = metres, .hypotheses = start.hypotheses()};
  const auto place = start.place();
  mark.behind = start.behind(truth);
  if (!place) return mark;
  const Eigen::Vector2d d(place->pose.x - truth.x, place->pose.y - truth.y);
  mark.sure = place->sure;
  mark.right =
      d.norm() < kRightDistance && std::abs(wrap_angle(place->pose.yaw - truth.yaw)) < kRightYaw;
  mark.elsewhere = place->elsewhere;
  mark.misfit = place->misfit;
  mark.alone = place->alone;
  mark.sigma = std::sqrt(place->covariance.topLeftCorner<2, 2>().trace());
  mark.inside = d.dot(place->covariance.topLeftCorner<2, 2>().inverse() * d) < kChiSquared99;
  return mark;
}

StartTrial try_start(streetmap::GlobalStart& start, const PlanarDrive& drive,
                     const std::vector<double>& driven, size_t first, uint64_t seed,
                     const StartStudyOptions& options) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const double scale = 1 + options.scale_sigma * normal(random);
  const double bias = options.yaw_bias_sigma * normal(random);
  StartTrial trial;
  trial.turns_500 = count_turns(drive, driven, first, 500);
  double next_mark = kMark, turned = 0;
  start.restart();
  for (size_t i = first + 1; i < driven.size(); ++i) {
    PlanarPose motion = drive.poses[i - 1].motion_to(drive.poses[i]);
    const double noise = options.motion_noise * std::hypot(motion.x, motion.y);
    motion.x = scale * motion.x + noise * normal(random);
    motion.y = scale * motion.y + noise * normal(random);
    if (noise > 0) {
      motion.yaw += drive.period * (bias + options.yaw_rate_noise * normal(random));
    }
    const double yaw = options.yaw_rate_noise * drive.period;
    const Eigen::Matrix3d covariance =
        Eigen::Vector3d(noise * noise, noise * noise, yaw * yaw).asDiagonal();
    const auto begin = std::chrono::steady_clock::now();
    start.move(motion, covariance, drive.period);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    trial.seconds += elapsed.count();
    trial.longest_move = std::max(trial.longest_move, elapsed.count());
    const double metres = driven[i] - driven[first];
    turned += std::abs(motion.yaw);
    if (metres >= next_mark) {
      trial.marks.push_back(mark_of(start, drive.poses[i], metres));
      const StartMark& mark = trial.marks.back();
      trial.marks.back().turned = turned;
      if (mark.sure && trial.sure_after < 0) trial.sure_after = metres;
      if (mark.sure && !mark.right) trial.wrong_metres += kMark;
      next_mark += kMark;
    }
    if (metres > options.length) break;
  }
  return trial;
}

}  // namespace

bool StartTrial::right_at(double metres) const {
  const auto index = static_cast<size_t>(metres / kMark) - 1;
  return index < marks.size() && marks[index].sure && marks[index].right;
}

StartWait StartTrial::waits_at(double metres, const streetmap::GlobalStartOptions& options) const {
  const auto index = static_cast<size_t>(metres / kMark) - 1;
  if (index >= marks.size() || right_at(metres)) return StartWait::kNothing;
  const StartMark& mark = marks[index];
  if (std::isinf(mark.behind)) return StartWait::kTruthDropped;
  if (!mark.right) return StartWait::kOtherLikelier;
  if (mark.elsewhere >= options.max_elsewhere) return StartWait::kOthers;
  if (mark.misfit >= options.max_mean_misfit) return StartWait::kMisfit;
  if (mark.sigma >= options.max_sigma) return StartWait::kSigma;
  return StartWait::kAlone;
}

void StartCounts::write_waits(std::ostream& out,
                              const streetmap::GlobalStartOptions& options) const {
  out << "| m | sure and right | truth dropped | another likelier | others not ruled out | misfit "
         "| sigma | alone not for long |\n|---|---|---|---|---|---|---|---|\n";
  for (const double metres : {200, 300, 400, 500, 600, 1000}) {
    int counts[7] = {};
    for (const StartTrial& t : trials) ++counts[static_cast<int>(t.waits_at(metres, options))];
    out << "| " << metres;
    for (const int count : counts) out << " | " << count;
    out << " |\n";
  }
}

void StartCounts::write_marks(std::ostream& out) const {
  out << "start,turns_500,m,turned,sure,right,hypotheses,elsewhere,misfit,alone,sigma,behind\n";
  for (size_t i = 0; i < trials.size(); ++i) {
    for (const StartMark& m : trials[i].marks) {
      out << i << ',' << trials[i].turns_500 << ',' << m.metres << ',' << m.turned << ',' << m.sure
          << ',' << m.right << ',' << m.hypotheses << ',' << m.elsewhere << ',' << m.misfit << ','
          << m.alone << ',' << m.sigma << ',' << m.behind << '\n';
    }
  }
}

void StartCounts::write(std::ostream& out, const std::string& what) const {
  const auto count = [&](const auto& predicate) {
    return static_cast<int>(std::count_if(trials.begin(), trials.end(), predicate));
  };
  const int all = static_cast<int>(trials.size());
  const int turning = count([](const StartTrial& t) { return t.turns_500 >= 2; });
  char line[256];
  std::snprintf(line, sizeof line,
                "%s: %d starts, %d with two turns within 500 m\n"
                "right within 500 m with two turns %d, within 1 km %d of all; sure and wrong %d\n",
                what.c_str(), all, turning,
                count([](const StartTrial& t) { return t.turns_500 >= 2 && t.right_at(500); }),
                count([](const StartTrial& t) { return t.right_at(1000); }),
                count([](const StartTrial& t) { return t.wrong_metres > 0; }));
  out << line << "| m | sure and right | likeliest is right | inside 99 % | hypotheses |\n"
      << "|---|---|---|---|---|\n";
  double seconds = 0, longest = 0;
  for (const StartTrial& t : trials) {
    seconds += t.seconds;
    longest = std::max(longest, t.longest_move);
  }
  for (const size_t i : {9, 19, 24, 29, 34, 39, 44, 49, 59, 69, 84, 99, 124, 149}) {
    int sure = 0, right = 0, inside = 0, n = 0;
    double hypotheses = 0;
    for (const StartTrial& t : trials) {
      if (i >= t.marks.size()) continue;
      const StartMark& mark = t.marks[i];
      ++n;
      sure += mark.sure && mark.right;
      right += mark.right;
      inside += mark.inside;
      hypotheses += mark.hypotheses;
    }
    if (n == 0) break;
    std::snprintf(line, sizeof line, "| %.0f | %.0f %% | %.0f %% | %.0f %% | %.0f |\n",
                  static_cast<double>(i + 1) * kMark, 100.0 * sure / n, 100.0 * right / n,
                  100.0 * inside / n, hypotheses / n);
    out << line;
  }
  std::snprintf(line, sizeof line, "%.0f ms per start, slowest motion %.1f ms\n",
                1e3 * seconds / std::max(all, 1), 1e3 * longest);
  out << line;
}

void try_starts(const streetmap::SegmentMap& map, const PlanarDrive& drive, int count,
                uint64_t seed, const StartStudyOptions& options, StartCounts& counts) {
  if (drive.poses.empty()) return;
  streetmap::GlobalStart start(map, options.start);
  const std::vector<double> driven = distances(drive);
  size_t last = 0;  // of the poses that leave room
  while (last < driven.size() && driven[last] + options.length < driven.back()) ++last;
  std::mt19937_64 random(seed);
  for (int i = 0; i < count && start.possible(); ++i) {
    // Places are spread over distance, not over time.
    const double place = std::uniform_real_distribution<double>(0, driven[last])(random);
    const auto first =
        static_cast<size_t>(std::lower_bound(driven.begin(), driven.end(), place) - driven.begin());
    counts.trials.push_back(try_start(start, drive, driven, first, random(), options));
  }
}

void try_drawn_towns(uint64_t first_seed, int towns, int starts, bool foreign,
                     const StartStudyOptions& options, StartCounts& counts) {
  for (uint64_t seed = first_seed; seed < first_seed + static_cast<uint64_t>(towns); ++seed) {
    DrawnTown town = draw_town(seed, 1414, 5000);
    if (foreign) town.drive = draw_town(seed + kForeignSeed, 1414, 5000).drive;
    const auto bytes = streetmap::rasterise(town.plan, {.margin = 60}, "drawn");
    if (!bytes) throw std::runtime_error(bytes.error().message());
    const auto map = streetmap::SegmentMap::open(*bytes, "drawn");
    if (!map) throw std::runtime_error(map.error().message());
    try_starts(*map, town.drive, starts, seed, options, counts);
  }
}

Result<StreetFile> read_streets(const std::string& path) {
  const auto read = osm::read_openstreetmap(path);
  if (!read) return tl::unexpected(read.error());
  const streetmap::StreetPlan plan = daemon::build_street_plan(*read).plan;
  auto bytes = streetmap::rasterise(plan, {}, path);
  if (!bytes) return tl::unexpected(bytes.error());
  StreetFile file{std::move(*bytes), {}, network_of(plan)};
  const auto opened = streetmap::SegmentMap::open(file.bytes, path);
  if (!opened) return tl::unexpected(opened.error());
  file.map = *opened;
  return file;
}

Result<PlanarDrive> read_drive(const streetmap::SegmentMap& map, const std::string& trajectory) {
  const streetmap::MapFrame& frame = map.frame();
  const auto recorded = simulator::read_trajectory(trajectory, {frame.latitude, frame.longitude});
  if (!recorded) return tl::unexpected(recorded.error());
  PlanarDrive drive;
  drive.period = recorded->sample_period;
  const std::vector<double> along = lengths(recorded->line);
  for (const double d : recorded->distances) {
    const Eigen::Vector2d place = point_at(recorded->line, along, d);
    const Eigen::Vector2d step = point_at(recorded->line, along, d + kHeadingReach) -
                                 point_at(recorded->line, along, d - kHeadingReach);
    drive.poses.push_back({place.x(), place.y(), std::atan2(step.y(), step.x())});
  }
  return drive;
}

std::string run_start_study(std::ostream& out, const StartStudyRun& run) {
  std::ofstream marks;
  if (!run.marks.empty()) marks.open(run.marks);
  const auto write = [&](const StartCounts& counts, const std::string& what) {
    counts.write(out, what);
    counts.write_waits(out, run.options.start);
    if (marks.is_open()) counts.write_marks(marks);
  };
  if (run.drawn > 0) {
    StartCounts counts;
    try_drawn_towns(run.seed, run.drawn, 10, run.foreign, run.options, counts);
    write(counts, run.foreign ? "drives through other towns" : "drawn towns");
  }
  const size_t step = run.walks > 0 ? 1 : 2;
  for (size_t i = 0; i + step <= run.files.size(); i += step) {
    const size_t other = run.foreign ? (i + step) % run.files.size() : i;
    const auto streets = read_streets(run.files[i]);
    if (!streets) return streets.error().message();
    StartCounts counts;
    if (run.walks > 0) {
      const auto driven = read_streets(run.files[other]);
      if (!driven) return driven.error().message();
      for (int k = 0; k < run.walks; ++k) {
        const uint64_t seed = run.seed + static_cast<uint64_t>(k);
        const PlanarDrive drive = draw_drive(driven->network, seed, 4000);
        try_starts(streets->map, drive, 10, seed, run.options, counts);
      }
      write(counts, run.files[i] + ", random drives on " + run.files[other]);
    } else {
      const auto drive = read_drive(streets->map, run.files[other + 1]);
      if (!drive) return drive.error().message();
      try_starts(streets->map, *drive, run.starts, run.seed, run.options, counts);
      write(counts, run.files[i] + ", " + run.files[other + 1]);
    }
  }
  return {};
}

}  // namespace infuse::study
