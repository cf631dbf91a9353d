#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/study/resume.hpp"
#include "tests/study/study_commands.hpp"
#ifdef INFUSE_SIMULATOR
#include "tests/study/rigs/compare_study.hpp"
#include "tests/study/rigs/drives_study.hpp"
#include "tests/study/rigs/far_study.hpp"
#include "tests/study/rigs/offset_study.hpp"
#include "tests/study/rigs/recorded_study.hpp"
#include "tests/study/rigs/refine_study.hpp"
#include "tests/study/rigs/rig_study.hpp"
#endif

namespace infuse::study {
namespace {

struct RigsArguments {
  uint64_t seed = 20'000;  // no other study draws from there
  int count = 20;
  int scenes = 40;
  double seconds = 40;
  bool quick = false;
  bool cells = false, unmeasured = false, any_heading = false, details = false;
  std::string output = "rigs.csv";
};

/// The summary of all trials goes to standard output.
int study_rigs([[maybe_unused]] const RigsArguments& arguments) {
#ifdef INFUSE_SIMULATOR
  const RigRecordingOptions recorded =
      arguments.cells
          ? RigRecordingOptions{.diverse = 40, .neighbours = 40}
          : RigRecordingOptions{.diverse = arguments.unmeasured ? 20 : 10, .neighbours = 0};
  const auto all = resume<RigTrial>(
      arguments.output, arguments.seed, arguments.count, read_rows, write_header, write_row,
      [&](uint64_t seed) -> std::vector<RigTrial> {
        const auto recording = record_random_rig(seed, recorded);
        if (!recording) {
          std::cerr << "infuse-study: rig " << seed << ": " << recording.error().message() << '\n';
          return {};
        }
        const TrialSet set = arguments.cells        ? TrialSet::kCells
                             : arguments.unmeasured ? TrialSet::kUnmeasured
                                                    : TrialSet::kTrust;
        return try_rig(*recording, seed, set, arguments.details ? &std::cout : nullptr);
      });
  write_summary(std::cout, all);
  return 0;
#else
  std::cerr << "infuse-study: built without the simulator\n";
  return 3;
#endif
}

/// Rigs drawn at random, each driven twice.
int study_drives([[maybe_unused]] RigsArguments arguments) {
#ifdef INFUSE_SIMULATOR
  if (arguments.quick) {
    arguments.count = 2;
    arguments.scenes = 8;
  }
  const auto all = resume<DrivesTrial>(
      arguments.output, arguments.seed, arguments.count, read_drives_rows, write_drives_header,
      write_drives_row, [&](uint64_t seed) -> std::vector<DrivesTrial> {
        auto trial = drive_twice(seed, {.scenes = arguments.scenes, .seconds = arguments.seconds});
        if (!trial) return {};
        return {*std::move(trial)};
      });
  write_drives_summary(std::cout, all);
  return 0;
#else
  std::cerr << "infuse-study: built without the simulator\n";
  return 3;
#endif
}

/// How often the better of two extrinsics is named, over rigs drawn at random.
int study_comparison([[maybe_unused]] const RigsArguments& arguments) {
#ifdef INFUSE_SIMULATOR
  CompareCounts counts;
  for (uint64_t seed = arguments.seed;
       seed < arguments.seed + static_cast<uint64_t>(arguments.count); ++seed) {
    const auto recording = record_random_rig(seed, {.diverse = 20, .neighbours = 0});
    if (recording) compare_on(*recording, seed, counts);
  }
  std::cout << counts.text();
  return 0;
#else
  std::cerr << "infuse-study: built without the simulator\n";
  return 3;
#endif
}

/// Refines wrong intrinsics of rigs drawn at random.
int study_refinement([[maybe_unused]] const RigsArguments& arguments) {
#ifdef INFUSE_SIMULATOR
  RefineCounts counts;
  std::cout << "seed,lidar,width,refined,usable,focal_percent,cx_px,cy_px,k1,sigma_focal_percent,"
               "sigma_cx,sigma_cy,sigma_k1,rotation_deg,translation_cm,cpu_s,reason\n";
  for (uint64_t seed = arguments.seed;
       seed < arguments.seed + static_cast<uint64_t>(arguments.count); ++seed) {
    const auto recording = record_random_rig(seed, {.diverse = arguments.scenes, .neighbours = 0});
    if (recording) refine_on(*recording, seed, std::cout, counts);
    std::cout << std::flush;
  }
  std::cout << counts.refined << " of " << counts.trials << " refined, " << counts.usable
            << " usable; of the refined ones " << counts.within << " within 0.5 %, 2 px, 0.01; "
            << counts.inside << " inside 95 %\n";
  return 0;
#else
  std::cerr << "infuse-study: built without the simulator\n";
  return 3;
#endif
}

/// Starts far from the truth.
int study_far_starts([[maybe_unused]] const RigsArguments& arguments) {
#ifdef INFUSE_SIMULATOR
  FarCounts counts;
  std::cout << "seed,lidar,width,heading_deg,right,usable,rotation_deg,translation_cm,mahalanobis2,"
               "cpu_s,reason\n";
  const int scenes = arguments.any_heading ? 20 : 6;
  for (uint64_t seed = arguments.seed;
       seed < arguments.seed + static_cast<uint64_t>(arguments.count); ++seed) {
    const auto recording = record_random_rig(seed, {.diverse = scenes, .neighbours = 0});
    if (!recording) continue;
    start_far(*recording, seed,
              arguments.any_heading ? FarStart::kAnyHeading : FarStart::kTenDegrees, std::cout,
              counts);
    std::cout << std::flush;
  }
  std::cout << counts.right << " of " << counts.trials << " right, " << counts.usable
            << " usable, of these " << counts.surely_wrong << " surely wrong\n";
  return 0;
#else
  std::cerr << "infuse-study: built without the simulator\n";
  return 3;
#endif
}

#ifdef INFUSE_SIMULATOR
/// Adds the study of a recorded drive's stated extrinsics.
void add_offset_command(CLI::App& app) {
  static std::string drive, camera;
  CLI::App* command = app.add_subcommand(
      "offset", "score a drive's stated extrinsics and ours on images that were held out");
  command->add_option("DRIVE", drive, "recorded drive")->required();
  command->add_option("--camera", camera, "camera, if there are several");
  command->callback([] {
    if (const auto done = study_offset(std::cout, drive, camera); !done) {
      throw std::runtime_error(done.error().message());
    }
  });
}

/// Adds the study of how far parts of a recorded drive, or two drives, agree.
void add_recorded_command(CLI::App& app) {
  static std::string drive, other;
  CLI::App* command =
      app.add_subcommand("recorded", "calibrate disjoint parts of a recorded drive, and another");
  command->add_option("DRIVE", drive, "recorded drive")->required();
  command->add_option("OTHER", other, "another drive of the rig");
  command->callback([] {
    if (const auto done = study_recorded(std::cout, drive, other); !done) {
      throw std::runtime_error(done.error().message());
    }
  });
}
#endif

}  // namespace

void add_rigs_commands(CLI::App& app, int& status) {
#ifdef INFUSE_SIMULATOR
  add_offset_command(app);
  add_recorded_command(app);
#endif
  static RigsArguments rigs;
  CLI::App* rigs_command = app.add_subcommand(
      "rigs", "calibrate rigs and worlds drawn at random, rightly and with faults");
  rigs_command->add_option("--seed", rigs.seed, "seed of the first rig (20000)");
  rigs_command->add_option("--count", rigs.count, "number of rigs (20)");
  rigs_command->add_flag("--cells", rigs.cells,
                         "right ones of 3 to 40 scenes, diverse and neighbouring, instead");
  rigs_command->add_flag("--unmeasured", rigs.unmeasured,
                         "right ones and cy + 15 px, with intrinsics that are stated and that are "
                         "not, 20 scenes, instead");
  rigs_command->add_flag("--details", rigs.details, "print what each stated covariance is made of");
  rigs_command->add_option("-o,--output", rigs.output,
                           "rows of all trials; an interrupted study goes on from it (rigs.csv)");
  rigs_command->callback([&status] { status = study_rigs(rigs); });

  static RigsArguments driven{.scenes = 24, .output = "drives.csv"};
  CLI::App* drives_command = app.add_subcommand(
      "drives", "drive rigs drawn at random twice, in other worlds, and compare the calibrations");
  drives_command->add_option("--seed", driven.seed, "seed of the first rig (20000)");
  drives_command->add_option("--count", driven.count, "number of rigs (20)");
  drives_command->add_option("--scenes", driven.scenes, "number of scenes of each drive (24)");
  drives_command->add_option("--seconds", driven.seconds, "duration of each drive (40)");
  drives_command->add_flag("--quick", driven.quick, "two rigs of 8 scenes");
  drives_command->add_option("-o,--output", driven.output,
                             "rows of all rigs; an interrupted study goes on from it (drives.csv)");
  drives_command->callback([&status] { status = study_drives(driven); });

  static RigsArguments compared;
  CLI::App* compare_command = app.add_subcommand(
      "compare", "compare right extrinsics of rigs drawn at random with wrong ones");
  compare_command->add_option("--seed", compared.seed, "seed of the first rig (20000)");
  compare_command->add_option("--count", compared.count, "number of rigs (20)");
  compare_command->callback([&status] { status = study_comparison(compared); });

  static RigsArguments refined;
  CLI::App* refine_command =
      app.add_subcommand("refine", "refine wrong intrinsics of rigs drawn at random");
  refine_command->add_option("--seed", refined.seed, "seed of the first rig (20000)");
  refine_command->add_option("--count", refined.count, "number of rigs (20)");
  refine_command->add_option("--scenes", refined.scenes, "number of scenes of each (40)");
  refine_command->callback([&status] { status = study_refinement(refined); });

  static RigsArguments far;
  CLI::App* far_command = app.add_subcommand(
      "far", "calibrate rigs drawn at random from 10 degrees off, with 6 scenes");
  far_command->add_option("--seed", far.seed, "seed of the first rig (20000)");
  far_command->add_option("--count", far.count, "number of rigs (20)");
  far_command->add_flag("--any-heading", far.any_heading,
                        "from any heading and 30 cm off, with 20 scenes, instead");
  far_command->callback([&status] { status = study_far_starts(far); });
}

}  // namespace infuse::study
