// Tables of the tracker on whole drives.
#include "drivers/measurement/angles.hpp"
#include "tests/bench/streetmap_sections.hpp"
#include "tests/study/streetmap/comparison_scores.hpp"

namespace infuse::streetmap::bench {

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

bool bare(std::ostream& out, int drives) {
  constexpr int kSeedsOfDrive = 2;
  constexpr int kFirstDrive = 11;  // the tracker was mended on those from 1
  out << kTableHeader;
  for (int i = 0; i < drives; ++i) {
    const std::string drive = "bare_" + std::to_string(kFirstDrive + i);
    if (!render(drive)) return false;
    const TestDrive test_drive{drive, read_views(drive), make_map(drive), kSeedsOfDrive};
    if (test_drive.views.empty()) return false;
    write_row(out, drive, test_drive.run({}));
  }
  return true;
}

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

}  // namespace infuse::streetmap::bench
