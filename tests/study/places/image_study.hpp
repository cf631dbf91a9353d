#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>

namespace infuse::study {

/// Sequences of images across seasons, P 6.2.3.
struct ImageStudyOptions {
  std::string map;       ///< street map, Altfeld
  uint64_t learnt = 81;  ///< seed of the town of which codewords are learned
  uint64_t tested = 91;  ///< and of that which is reported
  double spacing = 4;    ///< m between images
  double tolerance = 5;  ///< m, of a right place
};

/// Renders drives of a forward camera in five seasons through towns of other houses and trees, and
/// prints how often single images and sequences are found, by similarity (as the product), by
/// mutual information and by directed information P(6.1) of their codewords, with the images that
/// `infuse places` would state as found and how many of these are wrong. Throws std::runtime_error.
void study_images(std::ostream& out, const ImageStudyOptions& options);

}  // namespace infuse::study
