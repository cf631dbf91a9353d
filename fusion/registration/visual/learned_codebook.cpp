#include "fusion/registration/visual/learned_codebook.hpp"

#include <array>
#include <tuple>

#include "fusion/features/fpfh.hpp"

namespace infuse::registration {
namespace {

constexpr size_t kRows = std::tuple_size_v<features::Fpfh> + 128;  // FPFH and SIFT (Lowe 2004)

/// For each codeword its number of features and its elements, in 1/255.
constexpr auto kNumbers = std::to_array<uint16_t>({
#include "fusion/registration/visual/learned_codebook.inc"
});
static_assert(kNumbers.size() % (kRows + 1) == 0);

Codebook unpack() {
  constexpr size_t kWords = kNumbers.size() / (kRows + 1);
  Codebook codebook;
  codebook.words.resize(kRows, kWords);
  double total = 0;
  for (size_t w = 0; w < kWords; ++w) {
    const uint16_t* number = &kNumbers[w * (kRows + 1)];
    codebook.frequencies.push_back(number[0]);
    total += number[0];
    for (size_t r = 0; r < kRows; ++r) {
      codebook.words(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(w)) =
          static_cast<float>(number[r + 1]) / 255;
    }
  }
  for (double& f : codebook.frequencies) f /= total;
  return codebook;
}

}  // namespace

const Codebook& learned_codebook() {
  static const Codebook codebook = unpack();
  return codebook;
}

}  // namespace infuse::registration
