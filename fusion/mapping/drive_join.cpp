#include "fusion/mapping/drive_join.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <set>

#include "fusion/mapping/chi2.hpp"

namespace infuse::mapping {
namespace {

using geometry::Matrix6;
using geometry::transform_covariance;
using geometry::Vector6;

enum class Agreement : uint8_t { kAgrees, kContradicts, kUnrelated };

/// Compares what two closures say of the motion from the `from` of the first to the `to` of the
/// second: by the first and the further drive's odometry, by the earlier drive's and the second.
Agreement compare(const std::vector<Keyframe>& keyframes, const Closure& a, const Closure& b,
                  double widening) {
  const OdometryBetween later = odometry_between(keyframes, a.to, b.to);
  const OdometryBetween earlier = odometry_between(keyframes, a.from, b.from);
  const Eigen::Isometry3d by_a = a.T_from_to * later.T_from_to;
  const Eigen::Isometry3d by_b = earlier.T_from_to * b.T_from_to;
  const Matrix6 covariance = a.covariance + transform_covariance(a.T_from_to, later.covariance) +
                             earlier.covariance +
                             transform_covariance(earlier.T_from_to, b.covariance);
  const Vector6 error = geometry::log(by_a * by_b.inverse());
  const double chi2 = error.dot(Eigen::LDLT<Matrix6>(covariance).solve(error));
  return chi2 < widening * widening * kChi2Limit<3> ? Agreement::kAgrees : Agreement::kContradicts;
}

size_t drive_of(const std::vector<size_t>& first_keyframes, size_t keyframe) {
  return static_cast<size_t>(
      std::upper_bound(first_keyframes.begin(), first_keyframes.end(), keyframe) -
      first_keyframes.begin() - 1);
}

/// A keyframe of a drive, and its motion since the first keyframe of the drive that a walk began
/// at.
struct Reached {
  size_t keyframe = 0;
  OdometryBetween since;
};

OdometryBetween followed_by(const OdometryBetween& a, const OdometryBetween& b) {
  return {a.T_from_to * b.T_from_to,
          a.covariance + transform_covariance(a.T_from_to, b.covariance)};
}

OdometryBetween reversed(const OdometryBetween& motion) {
  const Eigen::Isometry3d T_to_from = motion.T_from_to.inverse();
  return {T_to_from, transform_covariance(T_to_from, motion.covariance)};
}

/// Where `links` lead from a drive, by drive: the fewest of them. It ends at drives before it.
std::vector<std::optional<Reached>> walk_links(const std::vector<Keyframe>& keyframes,
                                               const std::vector<size_t>& first_keyframes,
                                               const std::vector<Closure>& links, size_t drive) {
  std::vector<std::optional<Reached>> reached(first_keyframes.size());
  reached[drive] = Reached{first_keyframes[drive], {}};
  std::vector<size_t> next{drive};
  for (size_t i = 0; i < next.size(); ++i) {
    if (next[i] < drive) continue;
    const Reached at = *reached[next[i]];
    const auto follow = [&](size_t from, size_t to, const OdometryBetween& link) {
      const size_t other = drive_of(first_keyframes, to);
      if (drive_of(first_keyframes, from) != next[i] || reached[other]) return;
      const OdometryBetween way = odometry_between(keyframes, at.keyframe, from);
      reached[other] = Reached{to, followed_by(followed_by(at.since, way), link)};
      next.push_back(other);
    };
    for (const Closure& closure : links) {
      const OdometryBetween link{closure.T_from_to, closure.covariance};
      follow(closure.from, closure.to, link);
      follow(closure.to, closure.from, reversed(link));
    }
  }
  return reached;
}

}  // namespace

std::optional<std::string> AgreementOptions::invalid() const {
  if (min_closures < 2) return "min_closures must be at least 2";
  if (!(widening >= 1)) return "widening must be at least 1";
  if (!(max_rival >= 0 && max_rival <= 1)) return "max_rival must be between 0 and 1";
  return std::nullopt;
}

OdometryBetween odometry_between(const std::vector<Keyframe>& keyframes, size_t from, size_t to) {
  OdometryBetween between;
  for (size_t k = std::min(from, to); k < std::max(from, to); ++k) {
    between.covariance += transform_covariance(between.T_from_to, keyframes[k + 1].covariance);
    between.T_from_to =
        between.T_from_to * keyframes[k].T_odom_vehicle.inverse() * keyframes[k + 1].T_odom_vehicle;
  }
  if (from <= to) return between;
  return reversed(between);
}

std::vector<size_t> find_agreeing(const std::vector<Keyframe>& keyframes,
                                  const std::vector<size_t>& first_keyframes,
                                  const std::vector<Closure>& closures,
                                  const AgreementOptions& options) {
  const auto drive = [&](size_t keyframe) { return drive_of(first_keyframes, keyframe); };
  const auto comparison = [&](size_t a, size_t b) {
    const bool related = drive(closures[a].from) == drive(closures[b].from) &&
                         drive(closures[a].to) == drive(closures[b].to);
    return a == b     ? Agreement::kAgrees
           : !related ? Agreement::kUnrelated
                      : compare(keyframes, closures[a], closures[b], options.widening);
  };
  std::vector<size_t> accepted;
  for (size_t i = 0; i < closures.size(); ++i) {
    if (closures[i].accepted()) accepted.push_back(i);
  }
  std::vector<size_t> support;  // places of the further drive, by entry of `accepted`
  for (const size_t a : accepted) {
    std::set<size_t> places;
    for (const size_t b : accepted) {
      if (comparison(a, b) == Agreement::kAgrees) places.insert(closures[b].to);
    }
    support.push_back(places.size());
  }
  const auto best = std::max_element(support.begin(), support.end());
  if (best == support.end() || *best < options.min_closures) return {};
  const size_t chosen = accepted[static_cast<size_t>(best - support.begin())];
  std::vector<size_t> agreeing;
  for (size_t i = 0; i < accepted.size(); ++i) {
    const Agreement found = comparison(chosen, accepted[i]);
    if (found == Agreement::kAgrees) agreeing.push_back(accepted[i]);
    const bool rival =
        static_cast<double>(support[i]) > options.max_rival * static_cast<double>(*best);
    if (found == Agreement::kContradicts && rival) return {};
  }
  std::stable_sort(agreeing.begin(), agreeing.end(),
                   [&](size_t a, size_t b) { return closures[a].to < closures[b].to; });
  return agreeing;
}

std::optional<DriveJoin> join_by_links(const std::vector<Keyframe>& keyframes,
                                       const std::vector<size_t>& first_keyframes,
                                       const std::vector<Closure>& links, size_t drive) {
  DriveJoin join{first_keyframes[drive], {}};
  for (const Closure& closure : links) {
    if (closure.from < join.first && drive_of(first_keyframes, closure.to) == drive) {
      join.closures.push_back(closure);
    }
  }
  std::stable_sort(join.closures.begin(), join.closures.end(),
                   [](const Closure& a, const Closure& b) { return a.to < b.to; });
  if (!join.closures.empty()) return join;
  const auto reached = walk_links(keyframes, first_keyframes, links, drive);
  const auto before = std::find_if(reached.begin(), reached.begin() + static_cast<ptrdiff_t>(drive),
                                   [](const auto& other) { return other.has_value(); });
  if (before == reached.begin() + static_cast<ptrdiff_t>(drive)) return std::nullopt;
  const OdometryBetween back = reversed((*before)->since);
  Closure composed;
  composed.from = (*before)->keyframe;
  composed.to = join.first;
  composed.T_from_to = back.T_from_to;
  composed.covariance = back.covariance;
  join.closures.push_back(std::move(composed));
  return join;
}

std::vector<bool> find_linked_drives(const std::vector<Keyframe>& keyframes,
                                     const std::vector<size_t>& first_keyframes,
                                     const std::vector<Closure>& links, size_t drive) {
  const auto reached = walk_links(keyframes, first_keyframes, links, drive);
  std::vector<bool> linked(reached.size());
  for (size_t d = drive; d < reached.size(); ++d) linked[d] = reached[d].has_value();
  return linked;
}

}  // namespace infuse::mapping
