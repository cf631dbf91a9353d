// Wheels that lie, with and without a GNSS receiver and a lidar that measures the motion.
#include <cmath>

#include "daemon/health/odometry_health.hpp"
#include "daemon/pipeline/odometry_tracker.hpp"
#include "daemon/pipeline/street_map_motion.hpp"
#include "tests/bench/lying_drive.hpp"
#include "tests/bench/streetmap_sections.hpp"
#include "tests/fusion/motion/simulated_sensors.hpp"

namespace infuse::streetmap::bench {
namespace {

constexpr double kChiSquared99 = 9.21;                        // of two
constexpr double kMaxTrackedError = 3;                        // m
constexpr double kAfter = 60;                                 // s of driving, in which it recovers
constexpr double kTurnOfLidar = 0.1;                          // s
constexpr double kWheelInterval = 0.02;                       // s
constexpr double kGnssInterval = 0.2, kMapFixInterval = 0.5;  // s

/// What carries the odometry beside wheels and yaw rate.
struct Sources {
  bool gnss = false, lidar = false;
  const char* name = "";
};

struct WheelRun {
  double surely_wrong = 0;  // s TRACKING with the truth outside the 99 % region
  double furthest = 0;      // m off meanwhile
  bool recovered = false, named = false;
};

/// One drive, from a true start.
class WheelTrial {
 public:
  WheelTrial(const TestDrive& test_drive, const LyingDrive& lying, const Sources& sources,
             uint64_t seed)
      : views_(test_drive.views),
        lying_(lying),
        sources_(sources),
        random_(seed),
        sensors_(lying.drive(), seed),
        odometry_(settings(sources)),
        health_({}),
        tracker_(test_drive.made.map, options(seed)) {
    scale_ = 1 + 0.006 * normal_(random_);
    yaw_bias_ = 0.001 * normal_(random_);
    gnss_error_ = 4 * Eigen::Vector2d(normal_(random_), normal_(random_));
    while (next_view_ < views_.size() && views_[next_view_].seconds < lying.route_seconds(0)) {
      ++next_view_;
    }
    const PlanarPose truth = daemon::planar(lying.pose(0));
    tracker_.start(truth, Eigen::Vector3d(0.25, 0.25, 0.0025).asDiagonal());
  }

  WheelRun run(double seconds) {
    for (int i = 1; kTurnOfLidar * i < seconds; ++i) step(i);
    return result_;
  }

 private:
  static daemon::OdometrySettings settings(const Sources& sources) {
    daemon::OdometrySettings settings;
    settings.use_lidar = sources.lidar;
    return settings;
  }
  static TrackerOptions options(uint64_t seed) {
    TrackerOptions options;
    options.seed = 77 * seed;
    return options;
  }

  // One turn of the lidar.
  void step(int i) {
    const double from = kTurnOfLidar * (i - 1), to = kTurnOfLidar * i;
    for (double t = from + kWheelInterval; t < to + 1e-9; t += kWheelInterval) add_wheels(t);
    if (sources_.gnss && i % std::lround(kGnssInterval / kTurnOfLidar) == 0) {
      odometry_.add(sensors_.gnss(to));
    }
    const bool lidar = odometry_.wants_lidar();
    odometry_.mark(motion::seconds(to), lidar);
    odometry_.process_until(motion::seconds(to));
    if (lidar && lidar_before_) odometry_.add(sensors_.lidar(from, to));
    lidar_before_ = lidar;
    // A view belongs to the place where it was made.
    while (next_view_ < views_.size() && views_[next_view_].seconds <= lying_.route_seconds(to)) {
      double at = to;
      while (at > from && lying_.route_seconds(at) > views_[next_view_].seconds) at -= 0.005;
      predict_to(at);
      update(next_view_++);
      last_update_ = to;
    }
    predict_to(to);
    if (to - last_update_ >= kMapFixInterval && next_view_ > 0) {
      update(next_view_ - 1);  // it stands
      last_update_ = to;
    }
    if (sources_.gnss && i % std::lround(kMapFixInterval / kTurnOfLidar) == 0) add_fix(to);
    if (i % 10 == 0) check_health(to);
    judge(to);
  }

  void add_wheels(double t) {
    WheelOdometry wheels = sensors_.wheels(t, scale_, yaw_bias_);
    const bool rests = std::abs(lying_.drive().twist(t)[3]) < 0.01;
    for (size_t k = 0; k < 4; ++k) {
      const double factor = rests ? 0 : lying_.factor(k, t);
      wheels.wheel_speed[k] *= factor;
    }
    odometry_.add(wheels);
  }

  // Sweeps that odometry does not cover are not used.
  void update(size_t view) {
    if (!odometry_.trajectory().at(motion_.now()).usable()) return;
    tracker_.update(views_[view].samples);
  }

  void predict_to(double t) {
    if (motion::seconds(t) <= motion_.now()) return;
    motion_.predict(tracker_, odometry_.trajectory(), odometry_.predicted_pose(),
                    motion::seconds(t));
  }

  void add_fix(double t) {
    const PlanarPose truth = daemon::planar(lying_.pose(t));
    MapFix fix;
    fix.position = Eigen::Vector2d(truth.x, truth.y) + gnss_error_ +
                   Eigen::Vector2d(normal_(random_), normal_(random_));
    if (lying_.drive().twist(t)[3] > 2) fix.yaw = truth.yaw + 0.05 * normal_(random_);
    tracker_.add_fix(fix);
  }

  void check_health(double t) {
    const auto& checks = health_.update(motion::seconds(t), odometry_.status(motion::seconds(t)));
    for (const auto& finding : checks.findings()) {
      result_.named |= finding.what.find("by wheels") != std::string::npos;
    }
  }

  void judge(double t) {
    const TrackerEstimate estimate = tracker_.estimate();
    const PlanarPose truth = daemon::planar(lying_.pose(t));
    const Eigen::Vector2d d(estimate.pose.x - truth.x, estimate.pose.y - truth.y);
    const bool tracking = estimate.state == TrackState::kTracking;
    const Eigen::Matrix2d C = estimate.covariance.topLeftCorner<2, 2>();
    if (tracking && d.dot(C.inverse() * d) > kChiSquared99) {
      result_.surely_wrong += kTurnOfLidar;
      result_.furthest = std::max(result_.furthest, d.norm());
    }
    if (t > lying_.fault_end()) result_.recovered |= tracking && d.norm() < kMaxTrackedError;
  }

  const std::vector<View>& views_;
  const LyingDrive& lying_;
  Sources sources_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  motion::SimulatedSensors sensors_;
  daemon::OdometryTracker odometry_;
  daemon::OdometryHealth health_;
  Tracker tracker_;
  daemon::StreetMapMotion motion_;
  double scale_ = 1, yaw_bias_ = 0, last_update_ = 0;
  Eigen::Vector2d gnss_error_{0, 0};
  size_t next_view_ = 0;
  bool lidar_before_ = false;  // it measured the last turn too
  WheelRun result_;
};

std::string wheel_row(const TestDrive& test_drive, const geometry::Trajectory& route,
                      const WheelFault& fault, const Sources& sources) {
  constexpr double kFirstFault = 18, kBetween = 2.3, kMoreForCarrier = 11;  // s
  double worst = 0, furthest = 0;
  int wrong = 0, recovered = 0, named = 0;
  for (int i = 0; i < test_drive.seeds; ++i) {
    const double begin = kFirstFault + kBetween * i;
    const double length =
        std::min(begin + fault.seconds + kAfter + (fault.carried ? kMoreForCarrier : 0),
                 test_drive.views.back().seconds);
    const LyingDrive lying(route, test_drive.views.front().seconds, fault, begin, length);
    WheelTrial trial(test_drive, lying, sources, static_cast<uint64_t>(i) + 1);
    const WheelRun one = trial.run(length);
    worst = std::max(worst, one.surely_wrong);
    furthest = std::max(furthest, one.furthest);
    wrong += one.surely_wrong > 1;
    recovered += one.recovered;
    named += one.named;
  }
  return format_text("| %s | %s | %d | %.1f | %.1f | %d | %d | %d |\n", fault.name, sources.name,
                     test_drive.seeds, worst, furthest, wrong, recovered, named);
}

}  // namespace

void wheels(std::ostream& out, const TestDrive& test_drive) {
  constexpr WheelFault kFaults[] = {{"all locked, 0.5 s", 0.5, {0, 0, 0, 0}},
                                    {"all locked, 2 s", 2, {0, 0, 0, 0}},
                                    {"all locked, 5 s", 5, {0, 0, 0, 0}},
                                    {"all locked, 15 s", 15, {0, 0, 0, 0}},
                                    {"all + 10 %, 5 s", 5, {1.1, 1.1, 1.1, 1.1}},
                                    {"all + 30 %, 5 s", 5, {1.3, 1.3, 1.3, 1.3}},
                                    {"all + 100 %, 5 s", 5, {2, 2, 2, 2}},
                                    {"all − 10 %, 5 s", 5, {0.9, 0.9, 0.9, 0.9}},
                                    {"all − 30 %, 5 s", 5, {0.7, 0.7, 0.7, 0.7}},
                                    {"front locked, 2 s", 2, {0, 0, 1, 1}},
                                    {"front + 30 %, 5 s", 5, {1.3, 1.3, 1, 1}},
                                    {"one locked, 5 s", 5, {1, 1, 0, 1}},
                                    {"one + 50 %, 5 s", 5, {1, 1.5, 1, 1}},
                                    {"carried with wheels at rest, 15 s", 15, {0, 0, 0, 0}, true}};
  constexpr Sources kSources[] = {{false, false, "none"},
                                  {true, false, "GNSS"},
                                  {false, true, "lidar"},
                                  {true, true, "GNSS, lidar"}};
  out << "Wheels and yaw rate on a bus, beside them what the second column says. \"Surely wrong\": "
         "TRACKING with the truth\noutside the 99 % region; the most of a run. \"Recovered\": "
         "TRACKING within 3 m of the truth at most 60 s after the fault.\n\"Named\": runs in which "
         "an alert says that wheels contradict the other sources.\n\n"
      << "| wheels | beside them | runs | surely wrong, s | off, m | more than 1 s | recovered | "
         "named |\n|---|---|---|---|---|---|---|---|\n";
  const geometry::Trajectory route = read_truth(test_drive.drive);
  for (const WheelFault& fault : kFaults) {
    for (const Sources& sources : kSources) {
      const std::string row = wheel_row(test_drive, route, fault, sources);
      out << row << std::flush;
      std::fputs(row.c_str(), stderr);
    }
  }
}

}  // namespace infuse::streetmap::bench
