#include "tests/study/registration/recorded_scans.hpp"

#include <fstream>

#include "daemon/tools/align/align_scan.hpp"
#include "drivers/text/numbers.hpp"

namespace infuse::study {

Result<RecordedScans> read_recorded_scans(const std::filesystem::path& drive,
                                          const std::filesystem::path& poses) {
  RecordedScans out;
  std::ifstream rows(poses);
  for (std::string line; std::getline(rows, line);) {
    if (line.empty() || line.front() == '#') continue;
    const auto numbers = text::parse_numbers(line);
    if (!numbers || numbers->size() != 12) return fail("has a row that is no pose", poses.string());
    auto scan =
        daemon::read_align_scan(drive.string() + ":" + std::to_string(out.scans.size()), "", true);
    if (!scan) return tl::unexpected(scan.error());
    out.cameras = std::move(scan->cameras);
    PosedScan& posed = out.scans.emplace_back(
        PosedScan{.sweep = std::move(scan->sweep), .images = std::move(scan->images)});
    for (int i = 0; i < 12; ++i) {
      posed.T_world_lidar(i / 4, i % 4) = (*numbers)[static_cast<size_t>(i)];
    }
  }
  if (out.scans.empty()) return fail("has no poses", poses.string());
  return out;
}

}  // namespace infuse::study
