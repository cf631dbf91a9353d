#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace infuse::registration {

/// Quantises features to codewords, P 4.3.1.
struct Codebook {
  Eigen::MatrixXf words;            ///< one codeword per column, in the space of the features
  std::vector<double> frequencies;  ///< of each codeword in the scans it was learned from, sum 1

  size_t size() const { return frequencies.size(); }

  /// What is wrong with it, or nothing: sizes that differ, numbers that are not finite, a frequency
  /// of 0.
  std::optional<std::string> invalid() const;
};

/// Nearest codeword of every feature (one per column).
std::vector<uint32_t> quantise(const Codebook& codebook, const Eigen::MatrixXf& features);

/// Codewords of a scan and where they are.
struct CodewordCloud {
  Eigen::Matrix3Xf points;      ///< m, one per column
  std::vector<uint32_t> words;  ///< below the size of the codebook

  size_t size() const { return words.size(); }
};

}  // namespace infuse::registration
