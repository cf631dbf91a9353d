#include "daemon/mapping/closure_verifier.hpp"

#include <algorithm>

#include "fusion/places/outline_alignment.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kKeptSubmaps = 16;
constexpr size_t kRowsPerWrite = 8;

/// Splits a table into its header and its rows, each with its line end.
std::vector<std::string> split_rows(const std::string& text) {
  std::vector<std::string> rows;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    rows.push_back(text.substr(begin, end - begin));
    begin = end;
  }
  return rows;
}

}  // namespace

Result<void> ClosureVerifier::resume() {
  header_ = format_closures({});
  if (!folder_.has(map_file::kClosures)) return {};
  const auto text = folder_.read(map_file::kClosures);
  if (!text) return tl::unexpected(text.error());
  const auto parsed = parse_closures(*text, folder_.path_of(map_file::kClosures));
  if (!parsed) return tl::unexpected(parsed.error());
  rows_ = split_rows(*text);
  rows_.erase(rows_.begin());
  return {};
}

Result<std::shared_ptr<const mapping::PreparedSubmap>> ClosureVerifier::prepare(size_t keyframe) {
  const auto kept = std::find_if(prepared_.begin(), prepared_.end(),
                                 [&](const Prepared& p) { return p.keyframe == keyframe; });
  if (kept != prepared_.end()) return kept->submap;
  if (const std::string name = MapFolder::cloud_name(keyframe); !folder_.has(name)) {
    return fail("is missing", folder_.path_of(name), "make the map anew");
  }
  const auto cloud = folder_.read_cloud(drive_.keyframes, keyframe);
  if (!cloud) return tl::unexpected(cloud.error());
  if (prepared_.size() >= kKeptSubmaps) prepared_.pop_front();
  prepared_.push_back(
      {keyframe, std::make_shared<const mapping::PreparedSubmap>(*cloud, options_)});
  return prepared_.back().submap;
}

Result<void> ClosureVerifier::check(mapping::Closure& closure, std::optional<double> yaw) {
  const auto from = prepare(closure.from);
  if (!from) return tl::unexpected(from.error());
  const auto to = prepare(closure.to);
  if (!to) return tl::unexpected(to.error());
  const Eigen::Isometry3d& T_vehicle_lidar = drive_.T_vehicle_lidar;
  const Eigen::Isometry3d T_lidar_vehicle = T_vehicle_lidar.inverse();
  if (yaw) {
    closure.T_from_to = places::align_outlines((*from)->cloud.cloud.points(), T_vehicle_lidar,
                                               (*to)->cloud.cloud.points(), T_vehicle_lidar, *yaw);
  }
  mapping::ClosureCheck found = mapping::check_closure(
      **from, **to, T_lidar_vehicle * closure.T_from_to * T_vehicle_lidar, options_);
  if (!found.usable() && !closure.guessed) {
    found = mapping::check_closure(**from, **to, std::nullopt, options_);
  }
  closure.T_from_to = T_vehicle_lidar * found.registration.T_target_source * T_lidar_vehicle;
  if (found.usable()) {
    closure.covariance =
        geometry::transform_covariance(T_vehicle_lidar, found.registration.covariance);
  }
  closure.agreement = found.agreement;
  closure.overlap = found.overlap;
  closure.reason = found.reason;
  return {};
}

Result<void> ClosureVerifier::verify(mapping::Closure& closure, std::optional<double> yaw) {
  const bool known = next_ < rows_.size();
  if (!known) {
    if (auto checked = check(closure, yaw); !checked) return checked;
    rows_.push_back(format_closures({closure}).substr(header_.size()));
  }
  // What is used is what the file restores, in the first run as in one that goes on.
  const std::string file = folder_.path_of(map_file::kClosures);
  const auto parsed = parse_closures(header_ + rows_[next_], file);
  if (!parsed) return tl::unexpected(parsed.error());
  const mapping::Closure& restored = parsed->front();
  if (restored.from != closure.from || restored.to != closure.to ||
      restored.guessed != closure.guessed) {
    return fail("these closures are of another run", file, "remove the file");
  }
  closure = restored;
  ++next_;
  return known || next_ % kRowsPerWrite != 0 ? Result<void>() : write();
}

Result<void> ClosureVerifier::write() const {
  std::string text = header_;
  for (const std::string& row : rows_) text += row;
  return folder_.write(map_file::kClosures, text);
}

Result<void> ClosureVerifier::finish(const std::vector<mapping::Closure>& closures) {
  rows_.resize(closures.size());
  for (size_t i = 0; i < closures.size(); ++i) {
    // The reason is the last column: empty as verified, unless this is a run that went on.
    std::string& row = rows_[i];
    if (!closures[i].accepted() && row.ends_with(",\n")) {
      row.insert(row.size() - 1, closures[i].reason);
    }
  }
  return write();
}

}  // namespace infuse::daemon
