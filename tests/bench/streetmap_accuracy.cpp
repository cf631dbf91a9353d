// Makes the tables of fusion/streetmap/accuracy.md: single images, and the tracker on simulated
// drives.
//   streetmap_accuracy FOLDER [SECTION[=SEEDS]...]
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>

#include "drivers/measurement/angles.hpp"
#include "tests/bench/section_file.hpp"
#include "tests/bench/streetmap_runs.hpp"
#include "tests/study/starts/street_network.hpp"
#include "tests/study/streetmap/comparison_scores.hpp"
#include "tests/study/streetmap/single_image_pose.hpp"

namespace infuse::streetmap::bench {
namespace {

template <class... Values>
std::string format_text(const char* format, Values... values) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

struct Moments {
  double n = 0, sum = 0, squares = 0;
  void add(double x) {
    ++n;
    sum += x;
    squares += x * x;
  }
  double mean() const { return n > 0 ? sum / n : 0; }
  double sigma() const {
    return n > 0 ? std::sqrt(std::max(squares / n - mean() * mean(), 0.0)) : 0;
  }
};

// --- single images ---

struct ImageRow {
  Moments across, turned, seconds;
};

ImageRow locate_all(const SegmentMap& map, const std::vector<PosedImage>& posed_images,
                    const CameraMount& mount, int step, const SingleImageOptions& options) {
  const geometry::CameraModel camera(mount.intrinsics);
  ImageRow row;
  uint64_t draws = 1;
  for (const PosedImage& posed_image : posed_images) {
    ImageFeatures features;
    if (!extract_features(posed_image.image, step, features)) continue;
    // The error of the prior is up to half of the search range.
    const auto uniform = [&] {
      draws = draws * 6364136223846793005ULL + 1442695040888963407ULL;
      return static_cast<double>(draws >> 40) / (1 << 23) - 1;
    };
    const double lateral_offset = uniform(), yaw_offset = 10 * kDegree * uniform();
    const auto begin = std::chrono::steady_clock::now();
    const SingleImagePose pose =
        locate_from_image(map, features, camera, mount.T_camera_lidar,
                          posed_image.truth.compose({0, lateral_offset, yaw_offset}), options);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    if (!pose.usable()) continue;
    const PlanarPose found = posed_image.truth.compose({0, lateral_offset, yaw_offset})
                                 .compose({0, pose.lateral, pose.yaw});
    const PlanarPose error = posed_image.truth.motion_to(found);
    row.across.add(std::abs(error.y));
    row.turned.add(std::abs(error.yaw) / kDegree);
    row.seconds.add(elapsed.count() / static_cast<double>(pose.scores.size()));
  }
  return row;
}

bool one_image(std::ostream& out, int images) {
  if (!render("street")) return false;
  CameraMount mount;
  const std::vector<PosedImage> posed_images = read_posed_images("street", images, mount);
  const DriveMap made = make_map("street");
  out << "The drive `street` (fixtures/scenarios/online_2hz.toml): " << posed_images.size()
      << " images, reduced by 8; mean ± standard deviation of the error; time per\n"
      << "pose relative to LSMI, one thread.\n\n"
      << "| measure | lateral, m | heading, ° | time per pose | images |\n|---|---|---|---|---|\n";
  double unit = 0;
  for (const ImageMeasure measure :
       {ImageMeasure::kLsmi, ImageMeasure::kBlsmi, ImageMeasure::kMi, ImageMeasure::kQmi,
        ImageMeasure::kSce, ImageMeasure::kCorrelation, ImageMeasure::kBoundaries}) {
    SingleImageOptions options;
    options.measure = measure;
    // Slow measures use fewer pixels, or the table would take an hour.
    if (measure == ImageMeasure::kMi || measure == ImageMeasure::kCorrelation) {
      options.max_samples = 200;
    }
    if (measure == ImageMeasure::kMi) options.fit.centres = 20;
    if (measure == ImageMeasure::kMi) options.fit.sigmas = {1.0};
    const ImageRow row = locate_all(made.map, posed_images, mount, 8, options);
    if (measure == ImageMeasure::kLsmi) unit = row.seconds.mean();
    out << format_text("| %s | %.2f ± %.2f | %.1f ± %.1f | %.2f | %.0f |\n", name_of(measure),
                       row.across.mean(), row.across.sigma(), row.turned.mean(), row.turned.sigma(),
                       row.seconds.mean() / unit, row.across.n);
    std::fprintf(stderr, "%s: %.2f m\n", name_of(measure), row.across.mean());
  }
  out << "\nMLMI and dCor use 200 pixels, the others 1500; MLMI uses one kernel width.\n\n"
      << "| reduced by (LSMI) | lateral, m | heading, ° |\n|---|---|---|\n";
  for (const int step : {2, 4, 8, 16, 24}) {
    const ImageRow row = locate_all(made.map, posed_images, mount, step, {});
    out << format_text("| %d | %.2f ± %.2f | %.1f ± %.1f |\n", step, row.across.mean(),
                       row.across.sigma(), row.turned.mean(), row.turned.sigma());
  }
  return true;
}

// --- the tracker ---

constexpr const char* kTableHeader =
    "| | lateral, m | longitudinal, m | total, m | heading, ° | ends within 2 m | TRACKING | LOST "
    "| "
    "within 99 % |\n|---|---|---|---|---|---|---|---|---|\n";

void write_row(std::ostream& out, const std::string& what, const Summary& s) {
  const std::string row = format_text(
      "| %s | %.2f | %.2f | %.2f ± %.2f | %.2f | %.0f %% | %.1f %% | %.1f %% | %.1f %% |\n",
      what.c_str(), s.lateral, s.longitudinal, s.total, s.total_sigma, s.yaw / kDegree,
      100 * s.success, 100 * s.tracking, 100 * s.lost, 100 * s.inside_99);
  out << row << std::flush;
  std::fputs(row.c_str(), stderr);
  for (const auto& [reason, share] : s.doubts) {
    std::fprintf(stderr, "  %.1f %% %s\n", 100 * share, reason.c_str());
  }
}

/// Views of a drive, its map, and the number of seeds.
struct TestDrive {
  std::string drive;
  std::vector<View> views;  // empty if the drive is not available
  DriveMap made;
  int seeds = 0;

  Summary run(const RunOptions& options) const {
    return run_seeds(made.map, views, options, seeds);
  }
};

/// Writes the rows of a section for a drive.
using RowWriter = std::function<void(std::ostream&, const TestDrive&)>;

/// Writes the section of a drive: its name and its rows. False if the drive is not available.
bool write_drive_section(std::ostream& out, const std::string& drive, int seeds,
                         const RowWriter& rows) {
  if (!render(drive)) return false;
  const TestDrive test_drive{drive, read_views(drive), make_map(drive), seeds};
  if (test_drive.views.empty()) return false;
  out << "Drive `" << drive << "`, " << seeds << " seeds.\n\n";
  rows(out, test_drive);
  return true;
}

void one_drive(std::ostream& out, const TestDrive& test_drive) {
  out << kTableHeader;
  write_row(out, test_drive.drive, test_drive.run({}));
}

/// The kind of drive of the thesis, and the measures that it compares.
void robot(std::ostream& out, const TestDrive& test_drive) {
  out << kTableHeader;
  RunOptions options;
  write_row(out, "LSMI", test_drive.run(options));
  options.score = [&] { return std::make_unique<BaggedLsmiScore>(options.tracker.fit); };
  write_row(out, "BLSMI, 4 bags", test_drive.run(options));
  options.score = [] { return std::make_unique<BoundaryScore>(); };
  write_row(out, "road boundaries", test_drive.run(options));
}

void wrong_initial_poses(std::ostream& out, const TestDrive& test_drive) {
  out << kTableHeader;
  for (const double error : {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}) {
    RunOptions options;
    options.initial_error = error;
    write_row(out, format_text("%.0f m", error), test_drive.run(options));
  }
}

// --- right and wrong starts ---

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

/// From nothing: by the drive alone, and with what the sensors see.
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

void noisy_odometry(std::ostream& out, const TestDrive& test_drive) {
  out << "Gaussian noise in proportion to each motion and on its yaw rate, at the given rate.\n\n"
      << kTableHeader;
  for (const int noise_hz : {10, 2}) {
    for (const auto& [share, rate] : {std::pair(0.1, 1.0), {0.2, 2.0}, {0.3, 3.0}}) {
      RunOptions options;
      options.distance_noise = share;
      options.yaw_rate_noise = rate * kDegree;
      options.noise_hz = noise_hz;
      write_row(out, format_text("%.0f %%, %.0f °/s, at %d Hz", 100 * share, rate, noise_hz),
                test_drive.run(options));
    }
  }
}

void omission(std::ostream& out, const TestDrive& test_drive) {
  out << "100 particles.\n\n| omitted | total, m | time per update, relative to 90 % |\n"
      << "|---|---|---|\n";
  std::vector<std::pair<double, Summary>> rows;
  for (const double omitted : {0.0, 0.5, 0.7, 0.9, 0.97}) {
    RunOptions options;
    options.tracker.skipped_validation_share = omitted;
    options.tracker.max_validated = 100;
    options.tracker.particles.min_count = options.tracker.particles.max_count = 100;
    rows.emplace_back(omitted, test_drive.run(options));
  }
  for (const auto& [omitted, s] : rows) {
    out << format_text("| %.0f %% | %.2f ± %.2f | %.2f |\n", 100 * omitted, s.total, s.total_sigma,
                       s.seconds / rows[3].second.seconds);
  }
}

// --- wrong maps ---

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

// --- the file ---

constexpr const char* kDocumentHeader =
    "# Localisation accuracy on simulated drives\n\n"
    "Made by `./dev bench streetmap`, or section by section with `./dev bench "
    "streetmap:SECTION[=SEEDS]`:\n"
    "`one_image`, `kitti_00`, `kitti_05`, `kitti_07`, `street`, `country_road`, `motorway`, "
    "`robot`, `wrong_initial_poses`,\n"
    "`given_starts`, `given_starts_05`, `from_nothing`, `noisy_odometry`, `omission`, "
    "`wrong_maps`; sections that "
    "are missing below "
    "have not been run.\n"
    "The tracker runs on cached views, two per second, as in the daemon. Errors are rms over a run "
    "without its first ten\n"
    "views, averaged over seeds; a seed sets the scale and bias of the odometry, the initial pose "
    "and the filter. The world\n"
    "deviates from the map.\n";

const std::vector<infuse::bench::Section>& sections() {
  const auto on = [](const char* drive, const RowWriter& rows) {
    return
        [=](std::ostream& out, int seeds) { return write_drive_section(out, drive, seeds, rows); };
  };
  // All other sections use the shortest recorded route, or the street.
  const auto on_short = [](const RowWriter& rows) {
    return [=](std::ostream& out, int seeds) {
      return write_drive_section(out, "kitti_07", seeds, rows) ||
             write_drive_section(out, "street", seeds, rows);
    };
  };
  static const std::vector<infuse::bench::Section> all = {
      {"one_image", "A single image (I table 3.3, 3.6, figure 3.12)", 40, one_image},
      {"kitti_00", "The route of KITTI 00", 20, on("kitti_00", one_drive)},
      {"kitti_05", "The route of KITTI 05", 20, on("kitti_05", one_drive)},
      {"kitti_07", "The route of KITTI 07", 20, on("kitti_07", one_drive)},
      {"street", "A street", 20, on("street", one_drive)},
      {"country_road", "A country road", 10, on("country_road", one_drive)},
      {"motorway", "A motorway", 10, on("motorway", one_drive)},
      {"robot", "A robot in a pedestrian zone (I tables 3.5, 3.6)", 100,
       on("pedestrian_zone", robot)},
      {"wrong_initial_poses", "Wrong initial poses (I figure 3.19(c))", 20,
       on_short(wrong_initial_poses)},
      {"given_starts", "Right and wrong starts, KITTI 07", 10, on("kitti_07", given_starts)},
      {"given_starts_05", "Right and wrong starts, KITTI 05", 12, on("kitti_05", given_starts)},
      {"from_nothing", "From nothing", 8, on("kitti_07", from_nothing)},
      {"noisy_odometry", "Noisy odometry (I figure 3.19(b))", 20, on_short(noisy_odometry)},
      {"omission", "Omitted cross-validation (I figure 3.19(a))", 5, on_short(omission)},
      {"wrong_maps", "Wrong maps", 20, on_short(wrong_maps)}};
  return all;
}

/// `requested`: "NAME" or "NAME=SEEDS".
bool write_section(const std::string& path, const std::string& requested) {
  const size_t end = requested.find('=');
  const std::string name = requested.substr(0, end);
  for (const infuse::bench::Section& section : sections()) {
    if (section.name != name) continue;
    const int seeds =
        end == std::string::npos ? section.runs : std::atoi(requested.c_str() + end + 1);
    std::fprintf(stderr, "%s, %d\n", name.c_str(), seeds);
    return seeds > 0 &&
           infuse::bench::rewrite_section(path, kDocumentHeader, sections(), section, seeds);
  }
  std::fprintf(stderr, "unknown section %s\n", name.c_str());
  return false;
}

// A section without its recording is skipped; the others are still made.
int write_tables(const std::string& folder, std::vector<std::string> requested) {
  if (requested.empty()) {
    for (const infuse::bench::Section& section : sections()) requested.push_back(section.name);
  }
  bool made = true;
  for (const std::string& section : requested) {
    made = write_section(folder + "/accuracy.md", section) && made;
  }
  return made ? 0 : 1;
}

}  // namespace
}  // namespace infuse::streetmap::bench

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  return infuse::streetmap::bench::write_tables(argv[1], {argv + 2, argv + argc});
}
