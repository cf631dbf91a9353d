#pragma once

#include <random>

#include "fusion/registration/visual/codebook.hpp"

namespace infuse::registration {

/// Codewords on a line: word k is at k, so that neighbours are similar.
inline Codebook line_of_words(size_t words) {
  Codebook codebook;
  codebook.words =
      Eigen::RowVectorXf::LinSpaced(static_cast<Eigen::Index>(words), 0, float(words) - 1);
  codebook.frequencies.assign(words, 1 / static_cast<double>(words));
  return codebook;
}

/// Points of any word in a street, 80 m long, 24 m wide and 6 m high.
inline CodewordCloud draw_codewords(size_t count, size_t words, std::mt19937& random) {
  CodewordCloud cloud;
  const Eigen::Array3f size(80, 24, 6);
  std::uniform_real_distribution<float> share(-0.5F, 0.5F);
  cloud.points.resize(3, static_cast<Eigen::Index>(count));
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Array3f at(share(random), share(random), share(random));
    cloud.points.col(static_cast<Eigen::Index>(i)) = (at * size).matrix();
    cloud.words.push_back(static_cast<uint32_t>(random() % words));
  }
  return cloud;
}

/// The same codewords seen from `T_target_source`: positions err by `noise` (m) on each axis, a
/// share of the words is wrong, and a share of the points lies elsewhere.
inline CodewordCloud see_again(const CodewordCloud& target,
                               const Eigen::Isometry3d& T_target_source, size_t words, float noise,
                               double wrong, std::mt19937& random) {
  CodewordCloud source = draw_codewords(target.size(), words, random);
  std::normal_distribution<float> error(0, noise);
  std::uniform_real_distribution<double> share(0, 1);
  const Eigen::Isometry3f T = T_target_source.inverse().cast<float>();
  for (size_t i = 0; i < target.size(); ++i) {
    if (share(random) < wrong) continue;
    const auto column = static_cast<Eigen::Index>(i);
    const Eigen::Vector3f e(error(random), error(random), error(random));
    source.points.col(column) = T * (target.points.col(column) + e);
    if (share(random) >= wrong) source.words[i] = target.words[i];
  }
  return source;
}

}  // namespace infuse::registration
