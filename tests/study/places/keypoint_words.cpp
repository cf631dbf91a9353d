#include "tests/study/places/keypoint_words.hpp"

#include <cmath>
#include <stdexcept>

#include "fusion/registration/visual/sift_returns.hpp"

namespace infuse::study {
namespace {

constexpr float kReach = 39;       // m
constexpr float kSquared = 2.25F;  // m², of corresponding keypoints

registration::SiftReturns sift_of(const SeasonScan& scan, const Rig& rig) {
  const auto images = images_of(scan.scan, rig.cameras);
  auto found =
      registration::find_sift_returns({features::make_sweep_view(scan.scan.sweep), images}, 3);
  if (!found) throw std::runtime_error(found.error().message());
  return *std::move(found);
}

}  // namespace

Eigen::MatrixXf sift_descriptors(const SeasonScan& scan, const Rig& rig) {
  return sift_of(scan, rig).descriptors;
}

std::vector<Keypoint> find_keypoints(const SeasonScan& scan, const Rig& rig,
                                     const registration::Codebook& codebook) {
  const Sweep& sweep = scan.scan.sweep;
  const Eigen::Isometry3f T = rig.lidars.front().T_vehicle_lidar.cast<float>();
  const registration::SiftReturns sift = sift_of(scan, rig);
  const auto words = registration::quantise(codebook, sift.descriptors);
  std::vector<Keypoint> out;
  for (size_t k = 0; k < sift.size(); ++k) {
    const uint32_t i = sift.returns[k];
    const Eigen::Vector3f p = T * Eigen::Vector3f(sweep.x[i], sweep.y[i], sweep.z[i]);
    if (p.head<2>().norm() <= kReach) out.push_back({p, static_cast<uint16_t>(words[k])});
  }
  return out;
}

MapKeypoints::MapKeypoints(std::vector<Keypoint> keypoints)
    : keypoints_(std::move(keypoints)), at_(places::kPlaceVoxels) {
  for (size_t i = 0; i < keypoints_.size(); ++i) {
    const int at = places::voxel_index(keypoints_[i].point);
    if (at >= 0) at_[static_cast<size_t>(at)].push_back(static_cast<uint32_t>(i));
  }
}

int MapKeypoints::corresponding(const Eigen::Vector3f& point, uint16_t word) const {
  float nearest = kSquared;
  int found = -1;
  bool same = false;
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int at = places::voxel_index(point + Eigen::Vector3i(dx, dy, dz).cast<float>());
        if (at < 0) continue;
        for (const uint32_t i : at_[static_cast<size_t>(at)]) {
          const Keypoint& other = keypoints_[i];
          const float squared = (other.point - point).squaredNorm();
          if (squared > kSquared || (same && other.word != word)) continue;
          if ((other.word == word && !same) || squared < nearest) {
            same = other.word == word;
            nearest = squared;
            found = other.word;
          }
        }
      }
    }
  }
  return found;
}

double MapKeypoints::information(const std::vector<Keypoint>& query, double x, double y,
                                 double yaw) const {
  const auto c = static_cast<float>(std::cos(yaw)), s = static_cast<float>(std::sin(yaw));
  std::vector<std::pair<int, int>> pairs;
  for (const Keypoint& own : query) {
    const Eigen::Vector3f moved(c * own.point.x() - s * own.point.y() + static_cast<float>(x),
                                s * own.point.x() + c * own.point.y() + static_cast<float>(y),
                                own.point.z());
    const int word = corresponding(moved, own.word);
    if (word >= 0) pairs.emplace_back(word, own.word);
  }
  return places::word_information(pairs, query.size());
}

const char* name_of(FeatureSet set) {
  switch (set) {
    case FeatureSet::kReflectivityNormal:
      return "reflectivity, normals";
    case FeatureSet::kReflectivityGreyNormal:
      return "reflectivity and grey, normals";
    case FeatureSet::kSift:
      return "SIFT at returns";
    case FeatureSet::kReflectivityNormalSift:
      return "reflectivity, normals, SIFT";
    case FeatureSet::kAll:
      break;
  }
  return "reflectivity and grey, normals, SIFT";
}

std::array<double, kFeatureSets> information_of_sets(const places::TotalInformation& voxels,
                                                     double sift) {
  const double without = voxels.total(false), with = voxels.total(true);
  return {without, with, sift, without + sift, with + sift};
}

}  // namespace infuse::study
