#include <spdlog/fmt/fmt.h>

#include <cmath>

#include "daemon/owner/evaluation.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/trajectory_file.hpp"

namespace infuse::daemon {
namespace {

using motion::ErrorStatistics;

/// The file of a drive's true poses, or the file itself.
Result<std::filesystem::path> truth_file(const std::filesystem::path& truth) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(truth, ignored)) return truth;
  const auto drive = recording::Drive::open(truth);
  if (!drive) return tl::unexpected(drive.error());
  if (drive->description.truth_poses.empty()) {
    return fail("the drive has no ground-truth poses", truth.string(),
                "add poses to [truth] in drive.toml");
  }
  return drive->resolve(drive->description.truth_poses);
}

/// True if the stamps are line numbers, as in formats without times.
bool has_line_numbers(const std::vector<recording::TrajectoryPose>& poses) {
  for (size_t i = 0; i < poses.size(); ++i) {
    if (std::abs(poses[i].stamp.ns() - static_cast<int64_t>(i)) > 1) return false;
  }
  return true;
}

std::vector<geometry::StampedPose> stamped(const std::vector<recording::TrajectoryPose>& poses) {
  std::vector<geometry::StampedPose> stamped;
  for (const auto& pose : poses) stamped.push_back({pose.stamp, pose.T_frame_body});
  return stamped;
}

/// Pairs poses line by line, 0.1 s apart, as in KITTI's files.
std::vector<motion::PosePair> pair_by_line(const std::vector<recording::TrajectoryPose>& result,
                                           const std::vector<recording::TrajectoryPose>& truth) {
  std::vector<motion::PosePair> pairs;
  for (size_t i = 0; i < result.size(); ++i) {
    pairs.push_back({Stamp::from_ns(static_cast<int64_t>(i) * 100'000'000), result[i].T_frame_body,
                     truth[i].T_frame_body});
  }
  return pairs;
}

Json statistics_json(const ErrorStatistics& statistics, double factor) {
  return {{"rms", statistics.rms * factor},
          {"mean", statistics.mean * factor},
          {"median", statistics.median * factor},
          {"max", statistics.max * factor}};
}

const char* name_of(motion::Alignment alignment) {
  switch (alignment) {
    case motion::Alignment::kNone:
      return "none";
    case motion::Alignment::kFirstPose:
      return "first";
    case motion::Alignment::kRigid:
      return "rigid";
    case motion::Alignment::kSimilarity:
      return "similar";
  }
  return "";
}

std::string statistics_text(const char* what, const ErrorStatistics& s, double factor,
                            const char* unit) {
  return fmt::format("  {:<22} rms {:.3f}, mean {:.3f}, median {:.3f}, max {:.3f} {}\n", what,
                     s.rms * factor, s.mean * factor, s.median * factor, s.max * factor, unit);
}

}  // namespace

Result<TrajectoryScore> score_trajectory(const std::filesystem::path& result,
                                         const std::filesystem::path& truth,
                                         motion::Alignment alignment, Duration span) {
  const auto estimate = recording::read_trajectory(result);
  if (!estimate) return tl::unexpected(estimate.error());
  const auto file = truth_file(truth);
  if (!file) return tl::unexpected(file.error());
  const auto true_poses = recording::read_trajectory(*file);
  if (!true_poses) return tl::unexpected(true_poses.error());

  TrajectoryScore score;
  score.poses = estimate->size();
  score.truth_poses = true_poses->size();
  score.alignment = alignment;
  score.span = span;
  score.by_line = has_line_numbers(*estimate) || has_line_numbers(*true_poses);
  if (score.by_line && score.poses != score.truth_poses) {
    return fail(fmt::format("a file without times has {} poses, the other {}",
                            std::min(score.poses, score.truth_poses),
                            std::max(score.poses, score.truth_poses)),
                result.string(),
                "lines are compared one by one: give files of equal length, or TUM files");
  }
  const auto pairs = score.by_line ? pair_by_line(*estimate, *true_poses)
                                   : motion::pair_by_time(stamped(*estimate), stamped(*true_poses));
  score.paired = pairs.size();
  score.absolute = motion::absolute_error(pairs, alignment);
  score.relative = motion::relative_error(pairs, span);
  score.kitti = motion::kitti_error(pairs);
  return score;
}

Json to_json(const TrajectoryScore& score) {
  Json json = {{"kind", "trajectory"},
               {"poses", score.poses},
               {"truth_poses", score.truth_poses},
               {"paired", score.paired},
               {"paired_by", score.by_line ? "line" : "time"},
               {"alignment", name_of(score.alignment)},
               {"usable", score.absolute.usable()}};
  if (!score.absolute.usable()) {
    json["reason"] = score.absolute.reason;
    return json;
  }
  json["rms_m"] = score.absolute.translation.rms;
  json["absolute"] = {{"translation_m", statistics_json(score.absolute.translation, 1)},
                      {"rotation_deg", statistics_json(score.absolute.rotation, 1 / kDegree)}};
  if (score.alignment == motion::Alignment::kSimilarity) json["scale"] = score.absolute.scale;
  if (score.relative.usable()) {
    json["relative"] = {{"span_s", to_seconds(score.span)},
                        {"translation_m", statistics_json(score.relative.translation, 1)},
                        {"rotation_deg", statistics_json(score.relative.rotation, 1 / kDegree)}};
  }
  if (!score.kitti.usable()) return json;
  json["kitti"] = {{"segments", score.kitti.count},
                   {"translation_percent", 100 * score.kitti.translation},
                   {"rotation_deg_per_100m", 100 / kDegree * score.kitti.rotation},
                   {"lengths", Json::array()}};
  for (const motion::SegmentError& segment : score.kitti.segments) {
    if (segment.count == 0) continue;
    json["kitti"]["lengths"].push_back(
        {{"length_m", segment.length},
         {"segments", segment.count},
         {"translation_percent", 100 * segment.translation},
         {"rotation_deg_per_100m", 100 / kDegree * segment.rotation}});
  }
  return json;
}

std::string to_text(const TrajectoryScore& score) {
  std::string text = fmt::format("{} poses, {} of them with a true pose at the same {}\n",
                                 score.poses, score.paired, score.by_line ? "line" : "time");
  if (!score.absolute.usable()) return text + "  no score: " + score.absolute.reason + "\n";
  text += fmt::format("absolute, alignment: {}\n", name_of(score.alignment));
  text += statistics_text("position", score.absolute.translation, 1, "m");
  text += statistics_text("orientation", score.absolute.rotation, 1 / kDegree, "°");
  if (score.relative.usable()) {
    text += fmt::format("relative, over {:g} s\n", to_seconds(score.span));
    text += statistics_text("position", score.relative.translation, 1, "m");
    text += statistics_text("orientation", score.relative.rotation, 1 / kDegree, "°");
  }
  if (!score.kitti.usable()) {
    return text + "KITTI score: none,  " + score.kitti.reason + "\n";
  }
  return text + fmt::format("KITTI score: {:.3f} %, {:.4f} ° / 100 m over {} segments\n",
                            100 * score.kitti.translation, 100 / kDegree * score.kitti.rotation,
                            score.kitti.count);
}

}  // namespace infuse::daemon
