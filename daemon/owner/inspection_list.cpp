#include "daemon/owner/inspection_list.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/command_line/lidar_problems.hpp"

namespace infuse::daemon {
namespace {

/// "VLP-16, 20 sweeps (10.00/s), 0 lost" for each lidar of a capture.
std::string lidars_text(const Summary& summary) {
  std::string text;
  for (const auto& [id, device] : summary.sensors) {
    if (id.kind != SensorKind::kLidar) continue;
    const LidarCounters& c = summary.totals.counters.lidars.at(id.index);
    text += fmt::format("{}{}, {} sweeps ({:.2f}/s), {} of {} packets lost",
                        text.empty() ? "" : "; ", device.model, c.sweeps, sweep_rate(c),
                        c.lost_network + c.lost_kernel, c.packets + c.lost_network + c.lost_kernel);
  }
  return text;
}

std::string problems_text(const std::vector<std::string>& problems) {
  if (problems.empty()) return "no problems";
  const size_t more = problems.size() - 1;
  return (more == 0 ? "problem: " : fmt::format("{} problems: ", problems.size())) +
         problems.front() + (more == 0 ? "" : "; ...");
}

}  // namespace

std::string InspectionList::add(const std::filesystem::path& capture,
                                const Result<Inspection>& inspection) {
  const std::string name = capture.filename().string();
  ++captures_;
  if (!inspection) {
    ++with_problems_;
    return fmt::format("{}: {}\n", name, inspection.error().what);
  }
  const auto problems = list_problems(*inspection);
  with_lidar_ += has_lidar(*inspection) ? 1 : 0;
  with_problems_ += problems.empty() ? 0 : 1;
  if (!inspection->summary) return fmt::format("{}: {}\n", name, problems_text(problems));
  for (const LidarCounters& c : inspection->summary->totals.counters.lidars) {
    sweeps_ += c.sweeps;
    packets_ += c.packets;
    packets_lost_ += c.lost_network + c.lost_kernel;
  }
  return fmt::format("{}: {}; {}\n", name, lidars_text(*inspection->summary),
                     problems_text(problems));
}

std::string InspectionList::totals_text() const {
  return fmt::format(
      "{} captures, {} with a lidar, {} with problems: {} sweeps, {} of {} packets lost\n",
      captures_, with_lidar_, with_problems_, sweeps_, packets_lost_, packets_ + packets_lost_);
}

Json InspectionList::totals_json() const {
  return {{"captures", captures_}, {"with_lidar", with_lidar_}, {"with_problems", with_problems_},
          {"sweeps", sweeps_},     {"packets", packets_},       {"packets_lost", packets_lost_}};
}

}  // namespace infuse::daemon
