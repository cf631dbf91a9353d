#include <cmath>

#include "tests/bench/streetmap_sections.hpp"

namespace infuse::streetmap::bench {
namespace {

double distance_to(const Polyline& line, const PlanarPose& pose) {
  const Eigen::Vector2d p(pose.x, pose.y);
  double nearest = 1e9;
  for (size_t i = 0; i + 1 < line.size(); ++i) {
    const Eigen::Vector2d d = line[i + 1] - line[i];
    const double t = std::clamp((p - line[i]).dot(d) / std::max(d.squaredNorm(), 1e-9), 0.0, 1.0);
    nearest = std::min(nearest, (line[i] + t * d - p).norm());
  }
  return nearest;
}

PlanStrip& nearest_street(StreetPlan& plan, const PlanarPose& pose) {
  const auto key = [&](const PlanStrip& strip) {
    return strip.segment.kind == SegmentKind::kCarriageway ? distance_to(strip.points, pose) : 1e9;
  };
  return *std::min_element(plan.strips.begin(), plan.strips.end(),
                           [&](const auto& a, const auto& b) { return key(a) < key(b); });
}

}  // namespace

void wrong_maps(std::ostream& out, const TestDrive& test_drive) {
  const StreetPlan& plan = test_drive.made.plan;
  const PlanarPose middle = test_drive.views[test_drive.views.size() / 2].truth;
  out << kTableHeader;
  const auto write_changed_map = [&](const char* what,
                                     const std::function<void(StreetPlan&)>& change) {
    StreetPlan wrong = plan;
    change(wrong);
    const DriveMap made = make_map(test_drive.drive, wrong);
    write_row(out, what, run_seeds(made.map, test_drive.views, {}, test_drive.seeds));
  };
  write_changed_map("a street is missing", [&](StreetPlan& wrong) {
    PlanStrip& gone = nearest_street(wrong, middle);
    wrong.strips.erase(wrong.strips.begin() + (&gone - wrong.strips.data()));
  });
  write_changed_map("no buildings", [](StreetPlan& wrong) {
    std::erase_if(wrong.areas,
                  [](const PlanArea& area) { return area.segment.kind == SegmentKind::kBuilding; });
  });
  write_changed_map("streets 30 % wider", [](StreetPlan& wrong) {
    for (PlanStrip& strip : wrong.strips) strip.half_width *= 1.3;
  });
  write_changed_map("streets 30 % narrower", [](StreetPlan& wrong) {
    for (PlanStrip& strip : wrong.strips) strip.half_width *= 0.7;
  });
  write_changed_map("2 m shift within 80 m of a point", [&](StreetPlan& wrong) {
    const Eigen::Vector2d place(middle.x, middle.y);
    const Eigen::Vector2d aside(-std::sin(middle.yaw), std::cos(middle.yaw));
    const auto move = [&](Eigen::Vector2d& p) {
      if ((p - place).norm() < 80) p += 2 * aside;
    };
    for (PlanStrip& strip : wrong.strips) {
      for (Eigen::Vector2d& p : strip.points) move(p);
    }
    for (PlanArea& area : wrong.areas) {
      for (Polyline& ring : area.rings) {
        for (Eigen::Vector2d& p : ring) move(p);
      }
    }
  });
}

}  // namespace infuse::streetmap::bench
