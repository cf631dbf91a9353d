#include "tests/study/motion/sources_study.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <istream>
#include <limits>
#include <map>
#include <ostream>
#include <sstream>

#include "tests/study/motion/drawn_drive.hpp"

namespace infuse::study {
namespace {

using namespace motion;

constexpr double kSeconds = 60;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kHeader = "seed,fault,all,wheels and bus,wheels and gyro,gnss,lidar";

Used sources_of(SourceSet set, const DrawnDrive& d) {
  switch (set) {
    case SourceSet::kWheelsAndBus:
      return {d.wheels && d.bus, d.bus, false, false, false};
    case SourceSet::kWheelsAndGyro:
      return {d.wheels && d.gyro, false, d.wheels && d.gyro, false, false};
    case SourceSet::kGnss:
      return {false, false, false, d.gnss, false};
    case SourceSet::kLidar:
      return {false, false, false, false, d.lidar};
    default:
      return {d.wheels, d.bus, d.gyro, d.gnss, d.lidar};
  }
}

/// rms over stretches of 10 s; NaN if there is no pose.
double error_of(const geometry::Trajectory& trajectory, const TrueDrive& drive) {
  constexpr double kStretch = 10, kFrom = 15;  // s; until then what is constant is learned
  double square = 0;
  int count = 0;
  for (double t = kFrom; t + kStretch < kSeconds - 1; t += 1, ++count) {
    const auto from = trajectory.at(seconds(t)), to = trajectory.at(seconds(t + kStretch));
    if (!from.usable() || !to.usable()) return kNone;
    const Eigen::Isometry3d moved = from.T_odom_vehicle.inverse() * to.T_odom_vehicle;
    const Eigen::Isometry3d truth = drive.pose(t).inverse() * drive.pose(t + kStretch);
    square += (moved.translation() - truth.translation()).head<2>().squaredNorm();
  }
  return std::sqrt(square / count);
}

double error_with(const Used& used, const DrawnDrive& drawn, const TrueDrive& drive) {
  if (!used.wheels && !used.gnss && !used.lidar) return kNone;
  return error_of(drive_by(used, drawn, drive), drive);
}

void write_line(std::ostream& out, const std::string& name, std::vector<double> ratios) {
  std::sort(ratios.begin(), ratios.end());
  char line[96];
  std::snprintf(line, sizeof line, "| %s | %zu | %.2f | %.2f |\n", name.c_str(), ratios.size(),
                ratios[ratios.size() / 2], ratios.back());
  out << line;
}

}  // namespace

double SourcesTrial::ratio() const {
  double best = kNone;
  for (size_t set = 1; set < kSourceSets; ++set) best = std::fmin(best, error[set]);  // no NaN
  return error[0] / best;
}

SourcesTrial drive_by_sources(uint64_t seed) {
  const DrawnDrive drawn(seed);
  const TrueDrive drive = true_drive(drawn, kSeconds);
  SourcesTrial trial;
  trial.seed = seed;
  trial.fault = kFaultNames[drawn.fault];
  for (size_t set = 0; set < kSourceSets; ++set)
    trial.error[set] = error_with(sources_of(static_cast<SourceSet>(set), drawn), drawn, drive);
  return trial;
}

void write_sources_header(std::ostream& out) { out << kHeader << '\n'; }

void write_sources_row(std::ostream& out, const SourcesTrial& trial) {
  out << trial.seed << ',' << trial.fault;
  for (const double error : trial.error) out << ',' << error;
  out << '\n';
}

std::vector<SourcesTrial> read_sources_rows(std::istream& in) {
  std::vector<SourcesTrial> trials;
  for (std::string line; std::getline(in, line);) {
    SourcesTrial trial;
    std::istringstream fields(line);
    std::string field;
    size_t count = 0;
    for (; count < kSourceSets + 2 && std::getline(fields, field, ','); ++count) {
      char* end = nullptr;
      if (count == 0) trial.seed = std::strtoull(field.c_str(), &end, 10);
      if (count == 1) trial.fault = field;
      if (count >= 2) trial.error[count - 2] = std::strtod(field.c_str(), &end);
      if (count != 1 && *end != 0) break;
    }
    if (count == kSourceSets + 2 && !in.eof()) trials.push_back(trial);
  }
  return trials;
}

void write_sources_summary(std::ostream& out, const std::vector<SourcesTrial>& trials) {
  std::vector<double> all;
  std::map<std::string, std::vector<double>> by_fault;
  for (const SourcesTrial& trial : trials) {
    if (!std::isfinite(trial.ratio())) continue;
    all.push_back(trial.ratio());
    by_fault[trial.fault].push_back(trial.ratio());
  }
  out << "| fault | drives | error over that of the best sources alone, median | worst |\n"
      << "|---|---|---|---|\n";
  for (const auto& [fault, ratios] : by_fault) write_line(out, fault, ratios);
  if (!all.empty()) write_line(out, "all", all);
  out << trials.size() - all.size() << " drives without a pose somewhere\n";
}

}  // namespace infuse::study
