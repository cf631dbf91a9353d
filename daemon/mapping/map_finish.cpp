#include "daemon/mapping/map_finish.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "daemon/mapping/closure_verifier.hpp"
#include "daemon/mapping/g2o_file.hpp"
#include "daemon/mapping/place_map.hpp"
#include "drivers/gnss/local_frame.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "drivers/text/checksum.hpp"
#include "fusion/mapping/robust.hpp"

namespace infuse::daemon {
namespace {

constexpr double kUnknownHeight = 1e3;  // m, standard deviation
constexpr const char* kOutvoted = "contradicts the other closures";

using Descriptors = std::vector<places::PlaceDescriptor>;

std::vector<mapping::Keyframe> plain_keyframes(const MapDrive& drive) {
  std::vector<mapping::Keyframe> keyframes;
  for (const MapKeyframe& keyframe : drive.keyframes) keyframes.push_back(keyframe.keyframe);
  return keyframes;
}

mapping::PoseEdge<3> make_edge(size_t from, size_t to, const Eigen::Isometry3d& T_from_to,
                               const geometry::Matrix6& covariance, bool closure) {
  return {from, to, T_from_to, mapping::edge_information(T_from_to, covariance), closure};
}

mapping::PoseEdge<3> closure_edge(const mapping::Closure& closure, bool may_be_false) {
  return make_edge(closure.from, closure.to, closure.T_from_to, closure.covariance, may_be_false);
}

/// Keyframes where odometry has them, and the motions between them. Of a further drive one closure
/// that others agree with is as good as odometry.
mapping::PoseGraph<3> odometry_graph(const std::vector<mapping::Keyframe>& keyframes,
                                     const std::vector<mapping::DriveJoin>& joins) {
  mapping::PoseGraph<3> graph;
  size_t next_join = 0;
  Eigen::Isometry3d T_map_odom = Eigen::Isometry3d::Identity();
  for (size_t k = 0; k < keyframes.size(); ++k) {
    if (next_join < joins.size() && joins[next_join].first == k) {
      const mapping::Closure& closure = joins[next_join++].closures.front();
      T_map_odom = graph.poses[closure.from] * closure.T_from_to *
                   keyframes[closure.to].T_odom_vehicle.inverse();
      graph.edges.push_back(closure_edge(closure, false));
    } else if (k > 0) {
      graph.edges.push_back(make_edge(
          k - 1, k, keyframes[k - 1].T_odom_vehicle.inverse() * keyframes[k].T_odom_vehicle,
          keyframes[k].covariance, false));
    }
    graph.poses.push_back(T_map_odom * keyframes[k].T_odom_vehicle);
  }
  return graph;
}

/// Keyframes of which only those before a drive, its own and those of the drives that are linked
/// with it have their clouds.
std::vector<mapping::Keyframe> with_clouds_of(const std::vector<bool>& linked,
                                              const std::vector<size_t>& first_keyframes,
                                              size_t drive,
                                              std::vector<mapping::Keyframe> keyframes) {
  for (size_t d = drive; d < first_keyframes.size(); ++d) {
    const size_t end = d + 1 < first_keyframes.size() ? first_keyframes[d + 1] : keyframes.size();
    for (size_t k = first_keyframes[d]; k < end; ++k) {
      keyframes[k].has_cloud = keyframes[k].has_cloud && linked[d];
    }
  }
  return keyframes;
}

/// Seeks where the further drives of a merged map join those before; appends what was tried to
/// `closures`. Drives that were merged before are one body: any of them joins all. Fails if one
/// shares no place with those before.
Result<std::vector<mapping::DriveJoin>> join_drives(
    const MapFolder& folder, const MapDrive& drive, const std::vector<mapping::Keyframe>& keyframes,
    const Descriptors& descriptors, const places::JoinOptions& options, ClosureVerifier& verifier,
    const MapProgress& progress, std::vector<mapping::Closure>& closures) {
  std::vector<mapping::DriveJoin> joins;
  std::vector<mapping::Closure> links = drive.closures;
  const std::vector<size_t>& first = drive.first_keyframes;
  for (size_t d = 1; d < first.size(); ++d) {
    auto join = mapping::join_by_links(keyframes, first, links, d);
    if (!join) {
      const auto body = with_clouds_of(mapping::find_linked_drives(keyframes, first, links, d),
                                       first, d, keyframes);
      size_t accepted = 0;
      const auto search = places::search_join(body, descriptors, first, first[d], body.size(),
                                              options, [&](mapping::Closure& closure, double yaw) {
                                                progress(closure.to, keyframes.size(), accepted);
                                                auto verified = verifier.verify(closure, yaw);
                                                if (verified && closure.accepted()) ++accepted;
                                                return verified;
                                              });
      if (!search) return tl::unexpected(search.error());
      for (const size_t i : search->agreeing) links.push_back(search->tried[i]);
      closures.insert(closures.end(), search->tried.begin(), search->tried.end());
      join = mapping::join_by_links(keyframes, first, links, d);
      if (!join) {
        return fail(fmt::format("drive {} cannot be joined with those before it: of {} pairs of "
                                "places that look alike {} fit, and too few of these agree",
                                d + 1, search->tried.size(), accepted),
                    folder.path().string(), "merge a drive that shares a street with both");
      }
    }
    joins.push_back(*std::move(join));
  }
  return joins;
}

/// The fixes as positions about the first of them.
struct Georeference {
  double latitude = 0, longitude = 0, altitude = 0;  // rad, m
  std::vector<mapping::PositionFactor> factors;
};

Georeference make_georeference(const MapDrive& drive, const mapping::EarthFitOptions& options) {
  Georeference out;
  double last_way = -options.spacing;
  for (const MapFix& measured : drive.fixes) {
    const GnssFix& fix = measured.fix;
    const double way = drive.keyframes[measured.keyframe].keyframe.distance_driven;
    // Pose 1 is left without: an edge between successive ids of a graph is taken for odometry.
    if (measured.keyframe == 0 || way - last_way < options.spacing) continue;
    last_way = way;
    const bool has_height = std::isfinite(fix.altitude);
    if (out.factors.empty()) {
      out.latitude = fix.latitude;
      out.longitude = fix.longitude;
      out.altitude = has_height ? fix.altitude : 0;
    }
    const auto frame = gnss::make_local_frame(out.latitude, out.longitude, out.altitude);
    mapping::PositionFactor factor;
    factor.pose = measured.keyframe;
    factor.point = measured.point;
    factor.position = gnss::to_local(frame, fix.latitude, fix.longitude,
                                     has_height ? fix.altitude : out.altitude);
    const double sigma = options.sigma * (std::isfinite(fix.hdop) ? std::max(fix.hdop, 1.0) : 1.0);
    factor.sigma << sigma, sigma, has_height ? options.vertical_factor * sigma : kUnknownHeight;
    out.factors.push_back(factor);
  }
  return out;
}

/// The poses of keyframes of a fit.
std::vector<Eigen::Isometry3d> poses_of(const mapping::EarthFit& fit) {
  return {fit.graph.poses.begin() + 1, fit.graph.poses.end()};
}

double root_mean_square_move(const std::vector<Eigen::Isometry3d>& a,
                             const std::vector<Eigen::Isometry3d>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i)
    sum += (a[i].translation() - b[i].translation()).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

/// Optimises the graph with its closures; returns it without those that contradict.
Result<mapping::PoseGraph<3>> close_loops(mapping::PoseGraph<3> graph,
                                          const std::vector<mapping::Closure>& closures,
                                          MapSummary& summary, MapJson& outvoted) {
  const std::vector<Eigen::Isometry3d> before = graph.poses;
  std::vector<const mapping::Closure*> of_edge;
  const size_t steps = graph.edges.size();
  for (const mapping::Closure& closure : closures) {
    if (!closure.accepted()) {
      ++summary.rejected[closure.reason];
      continue;
    }
    graph.edges.push_back(closure_edge(closure, true));
    of_edge.push_back(&closure);
  }
  if (of_edge.empty()) return graph;
  const mapping::RobustResult robust = mapping::optimize_robustly(graph);
  summary.reason = robust.reason;
  mapping::PoseGraph<3> closed;
  closed.poses = graph.poses;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    if (e < steps || (e < robust.accepted.size() && robust.accepted[e] != 0)) {
      closed.edges.push_back(graph.edges[e]);
      summary.closures += e >= steps ? 1 : 0;
    } else {
      ++summary.rejected[kOutvoted];
      outvoted.push_back({of_edge[e - steps]->from, of_edge[e - steps]->to});
    }
  }
  mapping::PoseGraph<3> start = closed;
  start.poses = before;
  summary.cost_before = mapping::total_cost(start, mapping::Cost::kInformation);
  summary.cost = mapping::total_cost(closed, mapping::Cost::kInformation);
  summary.moved = root_mean_square_move(before, closed.poses);
  return closed;
}

/// The graph as a file: the map's origin is vertex 0, keyframe k is vertex k + 1.
std::string format_graph(const mapping::PoseGraph<3>& graph) {
  G2oGraph<3> file;
  file.graph = graph;
  for (size_t i = 0; i < graph.poses.size(); ++i) file.ids.push_back(static_cast<int64_t>(i));
  return format_g2o(file);
}

/// The poses of keyframes `first` to before `end`.
std::string format_trajectory(const std::vector<mapping::Keyframe>& keyframes,
                              const std::vector<Eigen::Isometry3d>& T_map_vehicle, size_t first,
                              size_t end) {
  std::vector<recording::TrajectoryPose> poses;
  for (size_t k = first; k < end; ++k) {
    poses.push_back({keyframes[k].stamp, T_map_vehicle[k]});
  }
  return recording::format_tum(poses);
}

MapJson georeference_json(const Georeference& origin) {
  return {{"latitude_deg", origin.latitude / kDegree},
          {"longitude_deg", origin.longitude / kDegree},
          {"altitude_m", origin.altitude}};
}

void describe_fit(const mapping::EarthFit& fit, MapSummary& summary) {
  if (!fit.usable()) summary.reason = fit.optimized.reason;
  summary.georeferenced = fit.georeferenced();
  summary.position_reason = fit.position_reason;
  summary.tilt_sigma = fit.tilt_sigma;
  summary.fixes = fit.accepted.size();
  summary.fixes_rejected = static_cast<size_t>(
      std::count(fit.accepted.begin(), fit.accepted.end(), static_cast<char>(0)));
  summary.fix_rms = fit.rms;
}

/// Why the odometry does not carry a map, or an empty text.
const char* unmeasured_reason(const MapSummary& summary, const MapSettings& settings) {
  const auto all = static_cast<double>(summary.sweeps);
  if (static_cast<double>(summary.unmeasured) > settings.max_unmeasured * all) {
    return "the motion of too many sweeps is not known";
  }
  return static_cast<double>(summary.unregistered) > settings.max_unregistered * all
             ? "the lidar did not measure the motion of too many sweeps"
             : "";
}

uint64_t count_at(const MapJson& json, const char* key) {
  return json.contains(key) && json[key].is_number_unsigned() ? json[key].get<uint64_t>() : 0;
}

/// Writes the files of a finished map; the manifest, which holds their checksums, is the last.
Result<void> write_files(const MapFolder& folder, const MapDrive& drive,
                         const std::vector<mapping::Keyframe>& keyframes,
                         const mapping::EarthFit& fit, MapJson manifest) {
  const std::vector<Eigen::Isometry3d> T_map_vehicle = poses_of(fit);
  std::vector<std::pair<std::string, std::string>> files{
      {map_file::kGraph, format_graph(fit.graph)}};
  for (size_t d = 0; d < drive.first_keyframes.size(); ++d) {
    const size_t end =
        d + 1 < drive.first_keyframes.size() ? drive.first_keyframes[d + 1] : keyframes.size();
    files.emplace_back(MapFolder::trajectory_name(d),
                       format_trajectory(keyframes, T_map_vehicle, drive.first_keyframes[d], end));
  }
  for (const auto& [name, text] : files) {
    if (auto written = folder.write(name, text); !written) return tl::unexpected(written.error());
    manifest["files"][name] = text::checksum(text);
  }
  for (const char* earlier : {map_file::kDrive, map_file::kClosures}) {
    const auto text = folder.read(earlier);
    if (!text) return tl::unexpected(text.error());
    manifest["files"][earlier] = text::checksum(*text);
  }
  return folder.write(map_file::kMap,
                      manifest.dump(1, ' ', false, MapJson::error_handler_t::replace) + "\n");
}

}  // namespace

Result<MapSummary> finish_map(const MapFolder& folder, const MapDrive& drive,
                              const MapSettings& settings, const MapProgress& progress) {
  MapSummary summary;
  const std::vector<mapping::Keyframe> keyframes = plain_keyframes(drive);
  summary.keyframes = keyframes.size();
  if (keyframes.size() < 2) {
    return fail("the drive has fewer than two keyframes", folder.path().string(),
                "the vehicle stands, or no motion was found");
  }
  summary.way = keyframes.back().distance_driven;
  summary.sweeps = count_at(drive.manifest, "sweeps");
  summary.unmeasured = count_at(drive.manifest, "unmeasured");
  summary.unregistered = count_at(drive.manifest, "unregistered");
  summary.drives = drive.first_keyframes.size();
  std::vector<mapping::Closure> closures;
  ClosureVerifier verifier(folder, drive, settings.check);
  if (auto resumed = verifier.resume(); !resumed) return tl::unexpected(resumed.error());
  const auto descriptors = read_places(folder, drive);
  if (!descriptors) return tl::unexpected(descriptors.error());
  const auto joins = join_drives(folder, drive, keyframes, *descriptors, settings.join, verifier,
                                 progress, closures);
  if (!joins) return tl::unexpected(joins.error());
  mapping::PoseGraph<3> graph = odometry_graph(keyframes, *joins);
  const Georeference origin =
      settings.use_gnss ? make_georeference(drive, settings.earth) : Georeference{};

  std::optional<mapping::KnownPoses> known;
  if (!origin.factors.empty()) {
    const auto fit = mapping::fit_to_earth(graph, origin.factors, settings.earth);
    if (fit.georeferenced()) known = mapping::KnownPoses{poses_of(fit), settings.earth.sigma};
  }
  if (settings.close_loops) {
    size_t accepted = 0;
    const auto found = mapping::search_closures(keyframes, *joins, drive.closures, known,
                                                settings.search, [&](mapping::Closure& closure) {
                                                  progress(closure.to, keyframes.size(), accepted);
                                                  auto verified = verifier.verify(closure);
                                                  if (verified && closure.accepted()) ++accepted;
                                                  return verified;
                                                });
    if (!found) return tl::unexpected(found.error());
    closures.insert(closures.end(), found->begin(), found->end());
  }
  if (auto written = verifier.finish(closures); !written) return tl::unexpected(written.error());

  closures.insert(closures.end(), drive.closures.begin(), drive.closures.end());
  MapJson outvoted = MapJson::array();
  auto closed = close_loops(graph, closures, summary, outvoted);
  if (!closed) return tl::unexpected(closed.error());
  const mapping::EarthFit fit = mapping::fit_to_earth(*closed, origin.factors, settings.earth);
  describe_fit(fit, summary);
  if (const char* wrong = unmeasured_reason(summary, settings); *wrong != '\0') {
    summary.reason = wrong;
  }

  summary.clouds = static_cast<size_t>(std::count_if(
      keyframes.begin(), keyframes.end(), [](const auto& keyframe) { return keyframe.has_cloud; }));

  MapJson manifest = drive.manifest;
  std::optional<std::vector<size_t>> kept;  // all where the poses that would choose are wrong
  if (summary.usable()) {
    kept = places::select_places(keyframes, poses_of(fit), *descriptors, settings.kept_clouds);
    summary.clouds = kept->size();
    manifest[kKeptClouds] = *kept;
  }
  manifest["georeference"] = fit.georeferenced() ? georeference_json(origin) : MapJson(nullptr);
  manifest["outvoted_closures"] = outvoted;
  manifest["summary"] = to_json(summary);
  const auto written = write_files(folder, drive, keyframes, fit, std::move(manifest));
  if (!written) return tl::unexpected(written.error());
  if (kept) folder.keep_clouds(*kept);  // the last step: the closures need all of them
  return summary;
}

}  // namespace infuse::daemon
