#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "fusion/mapping/pose_graph.hpp"

namespace infuse::daemon {

/// A pose graph as a file in g2o's text format states it. Poses are in the order of `ids`, which
/// increase; an edge that does not join the ids n and n + 1 is a closure.
template <int D>
struct G2oGraph {
  mapping::PoseGraph<D> graph;
  std::vector<int64_t> ids;  ///< of the poses in the file
  bool has_poses = false;    ///< the file states poses; else all are the identity
};

using G2oFile = std::variant<G2oGraph<2>, G2oGraph<3>>;

/// Parses VERTEX_SE2, EDGE_SE2, VERTEX_SE3:QUAT and EDGE_SE3:QUAT, of one dimension. Lines that are
/// empty or begin with # or FIX are skipped: the first pose is held in any case. Fails with the
/// line number if an element is not known or has not its count of finite numbers, a quaternion has
/// not norm 1 (within 1 %), an information is not positive semidefinite, an edge joins a pose to
/// itself or to one that is not among the poses of the file, or a pose is stated twice.
Result<G2oFile> parse_g2o(std::string_view text, const std::string& name);

/// Reads a file of at most 1 GiB.
Result<G2oFile> read_g2o(const std::filesystem::path& file);

/// Formats a graph with its poses; numbers have the digits that restore them.
template <int D>
std::string format_g2o(const G2oGraph<D>& file);

}  // namespace infuse::daemon
