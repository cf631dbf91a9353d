#include "daemon/mapping/g2o_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "drivers/recording/decompress.hpp"
#include "drivers/text/numbers.hpp"
#include "drivers/text/text_file.hpp"
#include "fusion/geometry/symmetric_eigen.hpp"

namespace infuse::daemon {
namespace {

using mapping::kPoseFreedom;
using mapping::Pose;
using mapping::PoseEdge;
using mapping::PoseMatrix;

/// Number of numbers of a pose.
template <int D>
constexpr size_t kPoseNumbers = D == 2 ? 3 : 7;
/// Number of numbers of an information: its upper triangle by row.
template <int D>
constexpr size_t kInformationNumbers = kPoseFreedom<D>*(kPoseFreedom<D> + 1) / 2;

constexpr double kNormTolerance = 0.01;

template <int D>
struct Names;
template <>
struct Names<2> {
  static constexpr std::string_view kVertex = "VERTEX_SE2", kEdge = "EDGE_SE2";
  static constexpr const char* kPoseHint = "a pose is: x y angle";
};
template <>
struct Names<3> {
  static constexpr std::string_view kVertex = "VERTEX_SE3:QUAT", kEdge = "EDGE_SE3:QUAT";
  static constexpr const char* kPoseHint = "a pose is: x y z qx qy qz qw";
};

/// Takes numbers from the front of a line.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}

  std::string_view word() { return text::next_word(rest_); }

  std::optional<int64_t> id() { return text::parse_integer(word()); }

  /// False if one is missing or is not a finite number.
  bool numbers(std::span<double> values) {
    for (double& value : values) {
      std::string_view text = word();
      if (text.starts_with('+')) text.remove_prefix(1);
      const auto number = text::parse_number(text);
      // Squares and products of larger numbers would overflow.
      if (!number || std::abs(*number) > 1e100) return false;
      value = *number;
    }
    return true;
  }

  bool at_end() { return word().empty(); }

 private:
  std::string_view rest_;
};

std::optional<Pose<2>> to_pose(const std::array<double, 3>& v) {
  Pose<2> T = Pose<2>::Identity();
  T.linear() = Eigen::Rotation2Dd(v[2]).toRotationMatrix();
  T.translation() << v[0], v[1];
  return T;
}

std::optional<Pose<3>> to_pose(const std::array<double, 7>& v) {
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!(std::abs(q.norm() - 1) <= kNormTolerance)) return std::nullopt;
  Pose<3> T = Pose<3>::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() << v[0], v[1], v[2];
  return T;
}

template <int D>
std::optional<PoseMatrix<D>> to_information(const std::array<double, kInformationNumbers<D>>& v) {
  PoseMatrix<D> information;
  size_t i = 0;
  for (int r = 0; r < kPoseFreedom<D>; ++r) {
    for (int c = r; c < kPoseFreedom<D>; ++c) information(r, c) = information(c, r) = v[i++];
  }
  const auto values = geometry::symmetric_eigen<kPoseFreedom<D>>(information).values;
  if (!(values.minCoeff() >= -1e-6 * values.maxCoeff())) return std::nullopt;
  return information;
}

/// Collects vertices and edges of one dimension.
template <int D>
class G2oReader {
 public:
  bool empty() const { return vertices_.empty() && edges_.empty(); }

  Result<void> add_vertex(Words& words, size_t line) {
    const auto id = words.id();
    std::array<double, kPoseNumbers<D>> numbers{};
    if (!id || *id < 0 || !words.numbers(numbers) || !words.at_end()) {
      return fail("not an id and " + std::to_string(numbers.size()) + " finite numbers", "",
                  Names<D>::kPoseHint);
    }
    const auto pose = to_pose(numbers);
    if (!pose) return fail("the norm of the quaternion is not 1", "", Names<D>::kPoseHint);
    vertices_.push_back({*id, line, *pose});
    return {};
  }

  Result<void> add_edge(Words& words, size_t line) {
    const auto from = words.id(), to = words.id();
    std::array<double, kPoseNumbers<D>> numbers{};
    std::array<double, kInformationNumbers<D>> upper{};
    if (!from || !to || *from < 0 || *to < 0 || !words.numbers(numbers) || !words.numbers(upper) ||
        !words.at_end()) {
      return fail(
          "not two ids and " + std::to_string(numbers.size() + upper.size()) + " finite numbers",
          "", "an edge is: from to pose information, the information's upper triangle by row");
    }
    const auto pose = to_pose(numbers);
    if (!pose) return fail("the norm of the quaternion is not 1", "", Names<D>::kPoseHint);
    const auto information = to_information<D>(upper);
    if (!information) return fail("the information is not positive semidefinite");
    if (*from == *to) return fail("the edge joins pose " + std::to_string(*from) + " to itself");
    edges_.push_back({*from, *to, line, *pose, *information});
    return {};
  }

  /// The graph; fails with the line of what is wrong.
  Result<G2oFile> finish(const std::string& name) {
    G2oGraph<D> file;
    file.has_poses = !vertices_.empty();
    std::stable_sort(vertices_.begin(), vertices_.end(),
                     [](const Vertex& a, const Vertex& b) { return a.id < b.id; });
    for (const Vertex& vertex : vertices_) {
      if (!file.ids.empty() && file.ids.back() == vertex.id) {
        return fail("pose " + std::to_string(vertex.id) + " is stated twice", where(name, vertex));
      }
      file.ids.push_back(vertex.id);
      file.graph.poses.push_back(vertex.pose);
    }
    if (!file.has_poses) {
      for (const Edge& edge : edges_) file.ids.insert(file.ids.end(), {edge.from, edge.to});
      std::sort(file.ids.begin(), file.ids.end());
      file.ids.erase(std::unique(file.ids.begin(), file.ids.end()), file.ids.end());
      file.graph.poses.assign(file.ids.size(), Pose<D>::Identity());
    }
    for (const Edge& edge : edges_) {
      const auto from = index(file.ids, edge.from), to = index(file.ids, edge.to);
      if (!from || !to) {
        return fail("no pose " + std::to_string(from ? edge.to : edge.from), where(name, edge),
                    "a file states all poses that its edges join, or none");
      }
      const bool closure = edge.to - edge.from != 1 && edge.from - edge.to != 1;
      file.graph.edges.push_back({*from, *to, edge.pose, edge.information, closure});
    }
    return file;
  }

 private:
  struct Vertex {
    int64_t id;
    size_t line;
    Pose<D> pose;
  };
  struct Edge {
    int64_t from, to;
    size_t line;
    Pose<D> pose;
    PoseMatrix<D> information;
  };

  static std::string where(const std::string& name, const auto& element) {
    return name + ":" + std::to_string(element.line);
  }

  static std::optional<size_t> index(const std::vector<int64_t>& ids, int64_t id) {
    const auto at = std::lower_bound(ids.begin(), ids.end(), id);
    if (at == ids.end() || *at != id) return std::nullopt;
    return static_cast<size_t>(at - ids.begin());
  }

  std::vector<Vertex> vertices_;
  std::vector<Edge> edges_;
};

Result<void> add_line(std::string_view line, size_t number, G2oReader<2>& planar,
                      G2oReader<3>& spatial) {
  Words words(line);
  const std::string_view element = words.word();
  if (element.empty() || element.starts_with('#') || element == "FIX") return {};
  if (element == Names<2>::kVertex) return planar.add_vertex(words, number);
  if (element == Names<2>::kEdge) return planar.add_edge(words, number);
  if (element == Names<3>::kVertex) return spatial.add_vertex(words, number);
  if (element == Names<3>::kEdge) return spatial.add_edge(words, number);
  constexpr size_t kShown = 40;
  return fail("unknown element '" + std::string(element.substr(0, kShown)) + "'", "",
              "known are VERTEX_SE2, EDGE_SE2, VERTEX_SE3:QUAT, EDGE_SE3:QUAT and FIX");
}

void append(std::string& text, const Pose<2>& T) {
  for (const double value :
       {T.translation().x(), T.translation().y(), std::atan2(T.linear()(1, 0), T.linear()(0, 0))}) {
    text::append_number(text += ' ', value);
  }
}

void append(std::string& text, const Pose<3>& T) {
  Eigen::Quaterniond q(T.linear());
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  for (const double value : {T.translation().x(), T.translation().y(), T.translation().z(), q.x(),
                             q.y(), q.z(), q.w()}) {
    text::append_number(text += ' ', value);
  }
}

}  // namespace

Result<G2oFile> parse_g2o(std::string_view text, const std::string& name) {
  G2oReader<2> planar;
  G2oReader<3> spatial;
  size_t number = 0;
  while (!text.empty()) {
    const size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    auto added = add_line(line, number, planar, spatial);
    if (added && !planar.empty() && !spatial.empty()) {
      added = fail("elements of two and of three dimensions", "", "a graph has one dimension");
    }
    if (!added) {
      Error error = added.error();
      error.where = name + ":" + std::to_string(number);
      return tl::unexpected(error);
    }
  }
  if (planar.empty() && spatial.empty()) {
    return fail("no pose graph", name, "expected lines such as EDGE_SE2 or EDGE_SE3:QUAT");
  }
  return planar.empty() ? spatial.finish(name) : planar.finish(name);
}

Result<G2oFile> read_g2o(const std::filesystem::path& file) {
  constexpr size_t kMaxBytes = size_t{1} << 30;
  auto opened = text::open_regular_file(file);
  if (!opened) return tl::unexpected(opened.error());
  if (const char* unpack = recording::unknown_compression(opened->get())) {
    return fail("is compressed in a way that is not read", file.string(),
                std::string("unpack it: ") + unpack);
  }
  const text::File plain(recording::decompress(opened->release()));
  if (!plain) return fail("cannot be read: no memory", file.string());
  const auto text = text::read_text(plain.get(), file, kMaxBytes);
  if (!text) return tl::unexpected(text.error());
  return parse_g2o(*text, file.string());
}

template <int D>
std::string format_g2o(const G2oGraph<D>& file) {
  std::string text;
  for (size_t i = 0; i < file.ids.size(); ++i) {
    text += Names<D>::kVertex;
    text::append_number(text += ' ', file.ids[i]);
    append(text, file.graph.poses[i]);
    text += '\n';
  }
  for (const PoseEdge<D>& edge : file.graph.edges) {
    text += Names<D>::kEdge;
    text::append_number(text += ' ', file.ids[edge.from]);
    text::append_number(text += ' ', file.ids[edge.to]);
    append(text, edge.T_from_to);
    for (int r = 0; r < kPoseFreedom<D>; ++r) {
      for (int c = r; c < kPoseFreedom<D>; ++c) {
        text::append_number(text += ' ', edge.information(r, c));
      }
    }
    text += '\n';
  }
  return text;
}

template std::string format_g2o(const G2oGraph<2>&);
template std::string format_g2o(const G2oGraph<3>&);

}  // namespace infuse::daemon
