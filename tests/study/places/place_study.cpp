#include "tests/study/places/place_study.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <memory>
#include <ostream>

#include "fusion/places/localiser.hpp"

namespace infuse::study {
namespace {

struct Start {
  places::Localiser localiser;
  Stamp stamp;
  double way = 0;
  bool on_map = true;
  double found_s = -1, found_m = -1;
  std::vector<geometry::StampedPose> tracked;
};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
}

/// The starts along a drive.
class Starts {
 public:
  Starts(const TrueMap& map, const LidarVisit& visit, const PlaceStudyOptions& options)
      : map_(map), visit_(visit), options_(options) {}

  void add(const geometry::PointsView& points, std::span<const float> reflectivity,
           const mapping::SweepMotion& motion) {
    way_ += motion.T_from_to.translation().norm();
    if (motion.measured && way_ >= next_) begin(motion.stamp);
    for (auto& start : starts_) {
      const auto pose = start->localiser.add(points, reflectivity, motion);
      if (!pose) error_ = pose.error().message();
      if (!pose || !pose->usable()) continue;
      if (start->found_s < 0) {
        start->found_s = to_seconds(motion.stamp - start->stamp);
        start->found_m = way_ - start->way;
      }
      start->tracked.push_back({motion.stamp, pose->T_map_vehicle});
    }
    for (auto& start : starts_) {
      const double driven = way_ - start->way;
      const bool done = driven > options_.max_way ||
                        (start->found_m >= 0 && driven > start->found_m + kTrackedWay);
      if (done) ended_.push_back(std::move(start));
    }
    std::erase(starts_, nullptr);
  }

  const std::string& error() const { return error_; }

  // A start whose drive ended before it was found or given up says nothing.
  void print(std::ostream& out, const std::string& name) const {
    size_t on_map = 0, found = 0, soon = 0, wrong = 0;
    std::vector<double> seconds, metres, errors;
    for (const auto& start : ended_) {
      on_map += start->on_map ? 1 : 0;
      if (start->found_s < 0) continue;
      if (start->on_map) {
        ++found;
        soon += start->found_s <= 10 ? 1 : 0;
        seconds.push_back(start->found_s);
        metres.push_back(start->found_m);
      }
      double worst = options_.elsewhere ? INFINITY : 0;
      if (!options_.elsewhere) {
        for (const motion::PosePair& pose : motion::pair_by_time(start->tracked, visit_.truth())) {
          errors.push_back(map_.error(pose.estimate, pose.truth));
          worst = std::max(worst, errors.back());
        }
      }
      wrong += worst > 1 ? 1 : 0;
    }
    out << std::fixed << std::setprecision(2) << name << " | " << on_map << " | "
        << ended_.size() - on_map << " | " << soon << " | " << found << " | " << wrong << " | "
        << quantile(seconds, 0.5) << " | " << quantile(metres, 0.5) << " | "
        << quantile(errors, 0.5) << ", " << quantile(errors, 0.95) << ", " << quantile(errors, 1)
        << std::endl;
  }

 private:
  static constexpr double kTrackedWay = 20;  // m

  void begin(Stamp stamp) {
    next_ = way_ + options_.spacing;
    const bool on_map = !options_.elsewhere && map_.covers(visit_.true_pose(stamp).translation());
    starts_.push_back(std::make_unique<Start>(Start{
        places::Localiser(map_.map, visit_.T_vehicle_lidar()), stamp, way_, on_map, -1, -1, {}}));
  }

  const TrueMap& map_;
  const LidarVisit& visit_;
  const PlaceStudyOptions& options_;
  std::vector<std::unique_ptr<Start>> starts_, ended_;
  double way_ = 0, next_ = 0;
  std::string error_;
};

}  // namespace

std::string study_places(std::ostream& out, const PlaceStudyOptions& options) {
  const auto map = open_true_map(options.map, options.map_drive);
  if (!map) return map.error().message();
  out << "drive | starts | off the map | found within 10 s | ever | wrong | s to the first, median "
         "| m | error, median, 95 %, max, m\n";
  for (const std::string& drive : options.drives) {
    const auto visit = LidarVisit::open(drive);
    if (!visit) return visit.error().message();
    Starts starts(*map, *visit, options);
    const std::string error = visit->play(
        [&](const auto& points, const auto& reflectivity, const mapping::SweepMotion& motion) {
          starts.add(points, reflectivity, motion);
        });
    if (!error.empty()) return error;
    if (!starts.error().empty()) return starts.error();
    starts.print(out, drive);
  }
  return "";
}

}  // namespace infuse::study
