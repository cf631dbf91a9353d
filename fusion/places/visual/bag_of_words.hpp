#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"

namespace infuse::places {

/// SIFT descriptors (Lowe 2004, by OpenCV) of the `most` strongest keypoints of an image, kGrey8 or
/// kBgr8, that are larger than its pixels: 128 rows, one column per keypoint, of unit length.
Eigen::MatrixXf sift_descriptors(const CameraFrame& frame, int most);

/// Bag of words (Sivic and Zisserman 2003, as in P 5.3.2): words of each place weighted by their
/// frequency, its root where they repeat (Jégou, Douze and Schmid 2009), and rarity among the
/// places. A vocabulary that is small against the keypoints of the places has no rare words.
class BagOfWords {
 public:
  /// `places` has the words of each place, below `vocabulary`.
  BagOfWords(const std::vector<std::vector<uint32_t>>& places, size_t vocabulary);

  /// Cosine of a query with each place, 0 … 1.
  Eigen::VectorXd similarities(const std::vector<uint32_t>& query) const;

 private:
  Eigen::VectorXd weigh(const std::vector<uint32_t>& words) const;
  Eigen::VectorXd rarity_;
  Eigen::MatrixXd places_;  // one column per place, unit length
};

}  // namespace infuse::places
