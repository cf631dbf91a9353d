#include "fusion/places/visual/bag_of_words.hpp"

#include <cmath>
#include <opencv2/features2d.hpp>

#include "fusion/registration/visual/grey_matrix.hpp"

namespace infuse::places {
namespace {

/// Diameter, pixels. What is finer is found in the doubled image alone (Lowe 2004, section 3.3):
/// the camera's noise, which no second visit shows.
constexpr float kMinKeypointSize = 4;

}  // namespace

Eigen::MatrixXf sift_descriptors(const CameraFrame& frame, int most) {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat found;
  const cv::Mat image = registration::grey_matrix(frame);
  const auto sift = cv::SIFT::create();
  sift->detect(image, keypoints);
  std::erase_if(keypoints, [](const cv::KeyPoint& k) { return k.size < kMinKeypointSize; });
  cv::KeyPointsFilter::retainBest(keypoints, most);
  sift->compute(image, keypoints, found);
  Eigen::MatrixXf out(128, found.rows);
  for (int row = 0; row < found.rows; ++row) {
    out.col(row) = Eigen::Map<const Eigen::VectorXf>(found.ptr<float>(row), 128).normalized();
  }
  return out;
}

BagOfWords::BagOfWords(const std::vector<std::vector<uint32_t>>& places, size_t vocabulary)
    : rarity_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(vocabulary))),
      places_(static_cast<Eigen::Index>(vocabulary), static_cast<Eigen::Index>(places.size())) {
  for (const auto& words : places) {
    std::vector<bool> seen(vocabulary, false);
    for (const uint32_t word : words) {
      if (!seen[word]) rarity_[word] += 1;
      seen[word] = true;
    }
  }
  const auto count = static_cast<double>(places.size());
  for (double& value : rarity_) value = std::log((1 + count) / (1 + value));
  for (size_t k = 0; k < places.size(); ++k)
    places_.col(static_cast<Eigen::Index>(k)) = weigh(places[k]);
}

Eigen::VectorXd BagOfWords::weigh(const std::vector<uint32_t>& words) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(rarity_.size());
  for (const uint32_t word : words) out[word] += 1;
  // A word that repeats, as of a row of windows, counts by the root of its number.
  out = out.cwiseSqrt().cwiseProduct(rarity_);
  const double norm = out.norm();
  if (norm > 0) out /= norm;
  return out;
}

Eigen::VectorXd BagOfWords::similarities(const std::vector<uint32_t>& query) const {
  return places_.transpose() * weigh(query);
}

}  // namespace infuse::places
