#include "fusion/places/visual/bag_of_words.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>

#include "fusion/registration/visual/grey_matrix.hpp"
#include "fusion/registration/visual/k_means.hpp"

namespace infuse::places {
namespace {

/// Diameter, pixels. What is finer is found in the doubled image alone (Lowe 2004, section 3.3):
/// the camera's noise, which no second visit shows.
constexpr float kMinKeypointSize = 4;
constexpr double kMinContrast = 0.015;     // in OpenCV's scale (decision 17)
constexpr int kKeypoints = 500;            // of an image; bounds time
constexpr int kColumns = 8, kRows = 6;     // parts of an image (decision 17)
constexpr size_t kWords = 2000;            // decision 17: of fewer every place has most
constexpr int kIterations = 8;             // of k-means; bounds time
constexpr Eigen::Index kSampled = 12'000;  // keypoints for k-means; bounds time

uint32_t part_of(const cv::KeyPoint& keypoint, const cv::Mat& image) {
  const auto at = [](float position, int size, int parts) {
    const float share = position / static_cast<float>(size);
    return std::clamp(static_cast<int>(share * static_cast<float>(parts)), 0, parts - 1);
  };
  return static_cast<uint32_t>(at(keypoint.pt.y, image.rows, kRows) * kColumns +
                               at(keypoint.pt.x, image.cols, kColumns));
}

}  // namespace

ImageKeypoints sift_keypoints(const CameraFrame& frame) {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat found;
  const cv::Mat image = registration::grey_matrix(frame);
  const auto sift = cv::SIFT::create(0, 3, kMinContrast);
  sift->detect(image, keypoints);
  std::erase_if(keypoints, [](const cv::KeyPoint& k) { return k.size < kMinKeypointSize; });
  cv::KeyPointsFilter::retainBest(keypoints, kKeypoints);
  sift->compute(image, keypoints, found);
  ImageKeypoints out{Eigen::MatrixXf(128, found.rows), {}};
  for (int row = 0; row < found.rows; ++row) {
    out.descriptors.col(row) =
        Eigen::Map<const Eigen::VectorXf>(found.ptr<float>(row), 128).normalized();
    out.parts.push_back(part_of(keypoints[static_cast<size_t>(row)], image));
  }
  return out;
}

registration::Codebook learn_sift_words(const std::vector<ImageKeypoints>& places) {
  Eigen::Index count = 0;
  for (const ImageKeypoints& place : places) count += place.descriptors.cols();
  const Eigen::Index stride = std::max<Eigen::Index>(1, count / kSampled);
  Eigen::MatrixXf samples(128, (count + stride - 1) / stride);
  Eigen::Index index = 0;
  for (const ImageKeypoints& place : places) {
    for (Eigen::Index k = 0; k < place.descriptors.cols(); ++k, ++index) {
      if (index % stride == 0) samples.col(index / stride) = place.descriptors.col(k);
    }
  }
  return registration::learn_codebook(samples, kWords, 1, kIterations);
}

std::vector<uint32_t> placed_words(const registration::Codebook& codebook,
                                   const ImageKeypoints& keypoints) {
  std::vector<uint32_t> words = registration::quantise(codebook, keypoints.descriptors);
  for (size_t k = 0; k < words.size(); ++k)
    words[k] += keypoints.parts[k] * static_cast<uint32_t>(codebook.size());
  return words;
}

size_t number_of_words(const registration::Codebook& codebook) {
  return codebook.size() * kColumns * kRows;
}

BagOfWords::BagOfWords(const std::vector<std::vector<uint32_t>>& places, size_t vocabulary)
    : rarity_(vocabulary, 0),
      of_word_(vocabulary),
      number_of_places_(static_cast<Eigen::Index>(places.size())) {
  for (std::vector<uint32_t> words : places) {
    std::sort(words.begin(), words.end());
    words.erase(std::unique(words.begin(), words.end()), words.end());
    for (const uint32_t word : words) rarity_[word] += 1;
  }
  const auto count = static_cast<double>(places.size());
  for (double& value : rarity_) value = std::log((1 + count) / (1 + value));
  for (size_t k = 0; k < places.size(); ++k) {
    for (const auto& [word, weight] : weigh(places[k]))
      of_word_[word].emplace_back(static_cast<uint32_t>(k), weight);
  }
}

BagOfWords::Weights BagOfWords::weigh(std::vector<uint32_t> words) const {
  std::sort(words.begin(), words.end());
  Weights out;
  for (const uint32_t word : words) {
    if (out.empty() || out.back().first != word) out.emplace_back(word, 0);
    out.back().second += 1;
  }
  double square = 0;
  for (auto& [word, weight] : out) {
    // A word that repeats, as of a row of windows, counts by the root of its number.
    weight = std::sqrt(weight) * rarity_[word];
    square += weight * weight;
  }
  for (auto& [word, weight] : out) weight /= square > 0 ? std::sqrt(square) : 1;
  return out;
}

Eigen::VectorXd BagOfWords::similarities(const std::vector<uint32_t>& query) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(number_of_places_);
  for (const auto& [word, weight] : weigh(query)) {
    for (const auto& [place, own] : of_word_[word]) out[place] += weight * own;
  }
  return out;
}

}  // namespace infuse::places
