#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/registration/visual/codebook.hpp"

namespace infuse::places {

/// Keypoints of an image, and in which part of it they are.
struct ImageKeypoints {
  Eigen::MatrixXf descriptors;  ///< 128 rows, one column per keypoint, of unit length
  std::vector<uint32_t> parts;  ///< of the image: of a grid of 8 by 6, row by row

  size_t size() const { return parts.size(); }
};

/// The 500 strongest SIFT keypoints (Lowe 2004, by OpenCV) of an image, kGrey8 or kBgr8, that are
/// larger than its pixels.
ImageKeypoints sift_keypoints(const CameraFrame& frame);

/// A codebook of 2000 words of keypoints that are spread evenly over places.
registration::Codebook learn_sift_words(const std::vector<ImageKeypoints>& places);

/// The word of each keypoint together with the part of the image that shows it, below
/// `number_of_words`: the vehicle drives in a lane and looks ahead, so that what is alike elsewhere
/// in the image is another place, or the same street from farther away (Lazebnik, Schmid and Ponce
/// 2006, the finest level).
std::vector<uint32_t> placed_words(const registration::Codebook& codebook,
                                   const ImageKeypoints& keypoints);

/// Number of placed words of a codebook.
size_t number_of_words(const registration::Codebook& codebook);

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
  using Weights = std::vector<std::pair<uint32_t, double>>;  // by word, or by place

  Weights weigh(std::vector<uint32_t> words) const;
  std::vector<double> rarity_;    // by word
  std::vector<Weights> of_word_;  // the places that have a word
  Eigen::Index number_of_places_ = 0;
};

}  // namespace infuse::places
