// Makes the tables behind fusion/streetmap/accuracy.md: single images, and the tracker on simulated
// drives.
//   streetmap_accuracy FOLDER [SECTION[=SEEDS]...]
#include <cstdio>
#include <cstdlib>

#include "tests/bench/section_file.hpp"
#include "tests/bench/streetmap_sections.hpp"

namespace infuse::streetmap::bench {
namespace {

constexpr const char* kDocumentHeader =
    "# Localisation accuracy on simulated drives\n\n"
    "Made by `./dev bench streetmap`, or section by section with `./dev bench "
    "streetmap:SECTION[=SEEDS]`:\n"
    "`one_image`, `kitti_00`, `kitti_05`, `kitti_07`, `street`, `country_road`, `motorway`, "
    "`bare`, `robot`, `wrong_initial_poses`,\n"
    "`given_starts`, `given_starts_05`, `from_nothing`, `large_maps`, `alike_streets`, "
    "`noisy_odometry`, "
    "`omission`, "
    "`wrong_maps`, `wheels`; sections that "
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
      {"bare", "Streets without buildings", 6, bare},
      {"robot", "A robot in a pedestrian zone (I tables 3.5, 3.6)", 100,
       on("pedestrian_zone", robot)},
      {"wrong_initial_poses", "Wrong initial poses (I figure 3.19(c))", 20,
       on_short(wrong_initial_poses)},
      {"given_starts", "Right and wrong starts, KITTI 07", 10, on("kitti_07", given_starts)},
      {"given_starts_05", "Right and wrong starts, KITTI 05", 12, on("kitti_05", given_starts)},
      {"from_nothing", "From nothing", 8, on("kitti_07", from_nothing)},
      {"large_maps", "From nothing on large maps", 20, large_maps},
      {"alike_streets", "From nothing on streets that look alike", 20, alike_streets},
      {"noisy_odometry", "Noisy odometry (I figure 3.19(b))", 20, on_short(noisy_odometry)},
      {"omission", "Omitted cross-validation (I figure 3.19(a))", 5, on_short(omission)},
      {"wrong_maps", "Wrong maps", 20, on_short(wrong_maps)},
      {"wheels", "Wheels that lie", 4, on_short(wheels)}};
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
