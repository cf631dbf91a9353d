// All tools in one program: infuse-align, infuse-calibrate, ... are links to it, and it does what
// the name says by which it was started. They link mostly the same libraries: as eight programs
// they took 22 MB of package.

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include "daemon/command_line/exit_code.hpp"
#include "daemon/command_line/tool.hpp"
#include "daemon/tools/align/align.hpp"
#include "daemon/tools/calibrate/calibrate.hpp"
#include "daemon/tools/calibrate_intrinsics/calibrate_intrinsics.hpp"
#include "daemon/tools/calibrate_target/calibrate_target.hpp"
#include "daemon/tools/export/export.hpp"
#include "daemon/tools/fleet/fleet.hpp"
#include "daemon/tools/import/import.hpp"
#include "daemon/tools/map/map.hpp"
#include "daemon/tools/places/places.hpp"

namespace {

using infuse::daemon::Command;

struct Entry {
  const char* name;
  Command (*declare)(CLI::App& infuse);
};

constexpr std::array<Entry, infuse::daemon::kTools.size()> kEntries = {{
    {"align", infuse::daemon::declare_align},
    {"calibrate", infuse::daemon::declare_calibrate},
    {"calibrate-intrinsics", infuse::daemon::declare_calibrate_intrinsics},
    {"calibrate-target", infuse::daemon::declare_calibrate_target},
    {"export", infuse::daemon::declare_export},
    {"fleet", infuse::daemon::declare_fleet},
    {"import", infuse::daemon::declare_import},
    {"map", infuse::daemon::declare_map},
    {"places", infuse::daemon::declare_places},
}};
static_assert(std::ranges::equal(kEntries, infuse::daemon::kTools,
                                 [](const Entry& entry, const infuse::daemon::Tool& tool) {
                                   return std::string_view(entry.name) == tool.name;
                                 }));

}  // namespace

int main(int argc, char** argv) {
  const std::string program = argc > 0 ? std::filesystem::path(argv[0]).filename().string() : "";
  for (const Entry& entry : kEntries) {
    if (program == std::string("infuse-") + entry.name)
      return infuse::daemon::run_tool(entry.name, entry.declare, argc, argv);
  }
  std::fprintf(stderr, "%s: not the name of a tool; run `infuse NAME` instead\n", program.c_str());
  return infuse::daemon::kUsage;
}
