// Starts of the tracker: stated ones, right and wrong, and from nothing.
#include <cmath>
#include <cstdlib>

#include "drivers/measurement/angles.hpp"
#include "tests/bench/streetmap_sections.hpp"
#include "tests/study/starts/street_network.hpp"

namespace infuse::streetmap::bench {
namespace {

/// Where a run starts, and the view by which it should have recovered.
struct GivenStart {
  size_t first_view = 0;
  size_t first_event = 0;  // the first turn of 45 degrees within 25 m, or crossing
  PlanarPose truth;
};

bool turns_before(const std::vector<View>& views, size_t first, size_t last) {
  double back = 0;
  for (size_t i = last; i > first && back < 25; --i) {
    const PlanarPose motion = views[i - 1].truth.motion_to(views[i].truth);
    back += std::hypot(motion.x, motion.y);
    if (std::abs(wrap_angle(views[last].truth.yaw - views[i - 1].truth.yaw)) > 45 * kDegree) {
      return true;
    }
  }
  return false;
}

/// Starts spread over the drive, each with room for its first turn or crossing and 60 s.
std::vector<GivenStart> given_starts_of(const TestDrive& test_drive, int count) {
  constexpr double kNear = 8, kAfter = 60;
  const std::vector<View>& views = test_drive.views;
  const auto crossings = study::crossings(study::network_of(test_drive.made.plan));
  std::vector<GivenStart> all, starts;
  for (size_t first = 0; first + 1 < views.size(); ++first) {
    for (size_t i = first + 1; i < views.size(); ++i) {
      const Eigen::Vector2d at(views[i].truth.x, views[i].truth.y);
      const bool crosses = std::any_of(crossings.begin(), crossings.end(),
                                       [&](const auto& c) { return (c - at).norm() < kNear; });
      if (!crosses && !turns_before(views, first, i)) continue;
      if (views[i].seconds + kAfter < views.back().seconds) {
        all.push_back({first, i, views[first].truth});
      }
      break;
    }
  }
  for (int i = 0; i < count && !all.empty(); ++i) {
    starts.push_back(all[static_cast<size_t>((i + 0.5) / count * static_cast<double>(all.size()))]);
  }
  return starts;
}

/// A pose on the nearest street that is parallel and at least 30 m aside; else 72 m to the left.
PlanarPose on_parallel_street(const StreetPlan& plan, const PlanarPose& truth) {
  PlanarPose best = truth.compose({0, 72, 0});
  double nearest = 150;
  for (const PlanStrip& strip : plan.strips) {
    if (strip.segment.kind != SegmentKind::kCarriageway || strip.half_width < 2.4) continue;
    for (size_t i = 1; i < strip.points.size(); ++i) {
      const Eigen::Vector2d d = strip.points[i] - strip.points[i - 1];
      const double yaw = std::atan2(d.y(), d.x());
      const double turned = wrap_angle(yaw - truth.yaw);
      if (std::abs(std::sin(turned)) > 0.25) continue;
      const Eigen::Vector2d middle = (strip.points[i] + strip.points[i - 1]) / 2;
      const PlanarPose motion = truth.motion_to({middle.x(), middle.y(), yaw});
      const double distance = std::hypot(motion.x, motion.y);
      if (std::abs(motion.y) < 30 || distance > nearest) continue;
      nearest = distance;
      const bool along = std::abs(turned) < 1;
      best = {middle.x(), middle.y(), along ? yaw : wrap_angle(yaw + 180 * kDegree)};
    }
  }
  return best;
}

struct StartRow {
  int runs = 0, recovered = 0, within_300 = 0, long_outside = 0, updates = 0, tracking = 0;
  double seconds = 0, longest_outside = 0;
};

void write_start_row(std::ostream& out, const std::string& name, bool gnss, const StartRow& row,
                     bool is_true, bool is_elsewhere) {
  const auto share = [](int count, int all) { return all > 0 ? 100.0 * count / all : 0.0; };
  std::string text = "| " + name + (gnss ? " | yes" : " | no") + format_text(" | %d |", row.runs);
  text += is_elsewhere ? std::string(" – |") : format_text(" %d |", row.recovered);
  text += is_true ? format_text(" %d | %.0f %% |", row.within_300, share(row.tracking, row.updates))
                  : std::string(" | |");
  text += format_text(" %d (%.0f s) |\n", row.long_outside, row.longest_outside);
  out << text << std::flush;
  std::fprintf(stderr, "%s", text.c_str());
}

}  // namespace

void given_starts(std::ostream& out, const TestDrive& test_drive) {
  constexpr size_t kViewsAfterRecovery = 20;
  constexpr double kRunSeconds = 60;
  out << "The start is stated within 2 m. A fix each half second, 1 m of noise, off by 4 m per "
         "axis (standard deviation,\nlasting), with a course above 2 m/s. \"Recovered\": TRACKING "
         "within 3 m of the truth, at "
         "most 60 s after the first turn of 45° or crossing; the run\nends 10 s later. True starts "
         "go on for 60 s: TRACKING within 300 m, and the share of the updates after the first.\n"
         "\"Outside\": runs with more than 1 s TRACKING while the truth is outside the 99 % region "
         "(the longest).\n\n"
      << "| start | GNSS | runs | recovered | TRACKING within 300 m | TRACKING afterwards | "
         "outside "
         "|\n|---|---|---|---|---|---|---|\n";
  const std::vector<GivenStart> starts = given_starts_of(test_drive, test_drive.seeds);
  const auto elsewhere_name = test_drive.drive == "kitti_05" ? "kitti_07" : "kitti_05";
  const bool has_elsewhere = is_rendered(elsewhere_name);
  const DriveMap elsewhere = has_elsewhere ? make_map(elsewhere_name) : DriveMap{};
  const PlanarPose kAhead{20, 0, 0}, kBehind{-20, 0, 0}, kLeft{0, 10, 0},
      kReversed{0, 0, 180 * kDegree};
  enum class Kind { kTrue, kOffset, kParallel, kElsewhere, kBadFixes, kShiftedMap };
  const struct {
    const char* name;
    Kind kind;
    PlanarPose offset;
    bool without, with;  // GNSS
  } rows[] = {{"true", Kind::kTrue, {}, true, true},
              {"20 m ahead", Kind::kOffset, kAhead, true, true},
              {"20 m behind", Kind::kOffset, kBehind, true, true},
              {"10 m left", Kind::kOffset, kLeft, true, true},
              {"parallel street", Kind::kParallel, {}, true, true},
              {"reversed", Kind::kOffset, kReversed, true, true},
              {"20 m off, 15 fixes with hdop 15", Kind::kBadFixes, {}, false, true},
              {"map shifted by 5 m", Kind::kShiftedMap, {}, false, true},
              {"another town's map", Kind::kElsewhere, {}, true, false}};
  int wrong = 0, wrong_outside = 0;
  for (const auto& [name, kind, offset, without, with] : rows) {
    if (kind == Kind::kElsewhere && !has_elsewhere) continue;
    for (const bool gnss : {false, true}) {
      if (!(gnss ? with : without)) continue;
      StartRow row;
      for (size_t i = 0; i < starts.size(); ++i) {
        const GivenStart& start = starts[i];
        RunOptions options;
        options.seed = i + 1;
        options.first_view = start.first_view;
        options.initial_error = 2;
        if (gnss) options.gnss_sigma = 4;
        const double event = test_drive.views[start.first_event].seconds;
        const double begin = test_drive.views[start.first_view].seconds;
        const double end = kind == Kind::kTrue ? begin + kRunSeconds : event + kRunSeconds;
        size_t last = start.first_event;
        while (last < test_drive.views.size() && test_drive.views[last].seconds < end) ++last;
        options.max_views = last - start.first_view;
        if (kind != Kind::kTrue && kind != Kind::kElsewhere) {
          options.views_after_recovery = kViewsAfterRecovery;
        }
        const double angle = 2.4 * static_cast<double>(i);
        const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
        const auto start_off_by = [&](double metres) {
          options.start_pose = {start.truth.x + metres * direction.x(),
                                start.truth.y + metres * direction.y(), start.truth.yaw};
        };
        if (kind == Kind::kOffset) options.start_offset = offset;
        if (kind == Kind::kParallel) {
          options.start_pose = on_parallel_street(test_drive.made.plan, start.truth);
        }
        if (kind == Kind::kBadFixes) {
          start_off_by(20);
          options.bad_fixes = 15;
          options.bad_fix_offset = 20 * direction;
        }
        if (kind == Kind::kShiftedMap) {
          start_off_by(5);
          options.gnss_sigma = 1;
          options.gnss_offset = 5 * direction;
        }
        const DriveMap& made = kind == Kind::kElsewhere ? elsewhere : test_drive.made;
        if (kind == Kind::kElsewhere) {
          const auto& strips = made.plan.strips;
          const PlanarPose middle{30 * direction.x() * static_cast<double>(i),
                                  30 * direction.y() * static_cast<double>(i), 0};
          options.start_pose = strips.empty() ? middle : on_parallel_street(made.plan, middle);
        }
        const RunResult result = run(made.map, test_drive.views, options);
        ++row.runs;
        row.long_outside += result.longest_outside > 1;
        row.longest_outside = std::max(row.longest_outside, result.longest_outside);
        row.recovered +=
            result.recovered_after >= 0 && result.recovered_after <= event - begin + kRunSeconds;
        row.seconds += result.seconds * result.updates;
        row.within_300 += result.metres_to_tracking >= 0 && result.metres_to_tracking <= 300;
        row.updates += result.updates_since_tracking;
        row.tracking += result.tracking;
        if (std::getenv("INFUSE_BENCH_VERBOSE") != nullptr) {
          std::fprintf(stderr,
                       "%s gnss %d start %zu view %zu: recovered %.1f outside %.1f updates "
                       "%d tracking %d metres %.0f, %.0f ms\n",
                       name, gnss, i, start.first_view, result.recovered_after,
                       result.longest_outside, result.updates, result.tracking,
                       result.metres_to_tracking, 1e3 * result.seconds);
        }
      }
      if (kind != Kind::kTrue) {
        wrong += row.runs;
        wrong_outside += row.long_outside;
      }
      write_start_row(out, name, gnss, row, kind == Kind::kTrue, kind == Kind::kElsewhere);
      std::fprintf(stderr, "%.0f s of processor time\n", row.seconds);
    }
  }
  out << format_text("\nWrong starts: %d, outside for more than 1 s: %d.\n", wrong, wrong_outside);
}

void from_nothing(std::ostream& out, const TestDrive& test_drive) {
  constexpr size_t kStartViews = 4;  // between starts
  out << "From nothing without GNSS to the end of the drive. \"Place\": within 12 m of the "
         "truth.\n\n"
      << "| places are searched by | starts | place found | after, m | TRACKING the truth | after, "
         "m "
         "| outside |\n|---|---|---|---|---|---|---|\n";
  for (const bool witnessed : {false, true}) {
    int found = 0, tracked = 0, outside = 0;
    double found_m = 0, tracked_m = 0;
    for (int i = 0; i < test_drive.seeds; ++i) {
      RunOptions options;
      options.from_nothing = true;
      options.seed = static_cast<uint64_t>(i) + 1;
      options.first_view = kStartViews * static_cast<size_t>(i);
      if (!witnessed) options.tracker.global_start.max_witnessed = 0;
      options.views_after_recovery = 10;
      const RunResult result = run(test_drive.made.map, test_drive.views, options);
      std::fprintf(stderr, "start %d: place after %.0f m, TRACKING after %.0f m, outside %.1f s\n",
                   i, result.started_metres, result.metres_to_tracking, result.longest_outside);
      outside += result.longest_outside > 1;
      if (result.started_metres >= 0) {
        ++found;
        found_m += result.started_metres;
      }
      if (result.recovered_after >= 0) {
        ++tracked;
        tracked_m += result.metres_to_tracking;
      }
    }
    const std::string row = format_text(
        "| %s | %d | %d | %.0f | %d | %.0f | %d |\n",
        witnessed ? "the drive, and sensors among few" : "the drive alone", test_drive.seeds, found,
        found_m / std::max(found, 1), tracked, tracked_m / std::max(tracked, 1), outside);
    out << row << std::flush;
    std::fputs(row.c_str(), stderr);
  }
}

}  // namespace infuse::streetmap::bench
