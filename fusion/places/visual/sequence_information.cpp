#include "fusion/places/visual/sequence_information.hpp"

#include <algorithm>

#include "fusion/dependence/directed_information.hpp"
#include "fusion/registration/visual/k_means.hpp"

namespace infuse::places {
namespace {

constexpr Eigen::Index kSampledCells = 60'000;  // of which words are learned

/// Features of the cells of images, one per column: of each image, cell by cell.
Eigen::MatrixXf cell_features(const std::vector<ImageDescriptor>& images) {
  const Eigen::Index rows = images.front().orientations;
  const Eigen::Index cells = static_cast<Eigen::Index>(images.front().values.size()) / rows;
  Eigen::MatrixXf features(rows, cells * static_cast<Eigen::Index>(images.size()));
  for (size_t k = 0; k < images.size(); ++k) {
    features.middleCols(static_cast<Eigen::Index>(k) * cells, cells) =
        Eigen::Map<const Eigen::MatrixXf>(images[k].values.data(), rows, cells);
  }
  return features;
}

/// The sequence of every cell over images `begin` … `begin + count` − 1, one after the other.
std::vector<int32_t> cell_sequences(const CellWords& words, size_t begin, size_t count) {
  std::vector<int32_t> out;
  out.reserve(count * words.front().size());
  for (size_t cell = 0; cell < words.front().size(); ++cell) {
    for (size_t k = begin; k < begin + count; ++k) out.push_back(words[k][cell]);
  }
  return out;
}

/// The best of the scores, where entry 0 stands for place `first`, and the best elsewhere.
SequenceMatch best_of(const std::vector<double>& scores, size_t first, size_t neighbourhood) {
  const auto best = std::max_element(scores.begin(), scores.end());
  const auto at = static_cast<size_t>(best - scores.begin());
  SequenceMatch match{.place = first + at, .score = *best, .margin = 0, .runner_up = first + at};
  for (size_t j = 0; j < scores.size(); ++j) {
    const size_t distance = j > at ? j - at : at - j;
    if (distance <= neighbourhood) continue;
    if (match.runner_up != match.place && *best - scores[j] >= match.margin) continue;
    match.margin = *best - scores[j];
    match.runner_up = first + j;
  }
  return match;
}

}  // namespace

registration::Codebook learn_cell_words(const std::vector<ImageDescriptor>& images, size_t words) {
  const Eigen::MatrixXf features = cell_features(images);
  const Eigen::Index stride = std::max<Eigen::Index>(1, features.cols() / kSampledCells);
  const Eigen::MatrixXf samples = features(Eigen::all, Eigen::seq(0, features.cols() - 1, stride));
  return registration::learn_codebook(samples, words, 1);
}

CellWords cell_words(const std::vector<ImageDescriptor>& images,
                     const registration::Codebook& codebook) {
  const auto words = registration::quantise(codebook, cell_features(images));
  const size_t cells = words.size() / images.size();
  CellWords out(images.size());
  for (size_t k = 0; k < words.size(); ++k)
    out[k / cells].push_back(static_cast<int32_t>(words[k]));
  return out;
}

std::vector<SequenceMatch> match_by_information(const CellWords& queries, const CellWords& places,
                                                const SequenceInformationOptions& options) {
  const size_t used = std::min({options.length, queries.size(), places.size()});
  std::vector<SequenceMatch> out;
  if (used == 0) return out;
  std::vector<std::vector<int32_t>> of_map;
  for (size_t j = 0; j + used <= places.size(); ++j)
    of_map.push_back(cell_sequences(places, j, used));
  std::vector<double> scores(of_map.size());
  for (size_t i = 0; i < queries.size(); ++i) {
    const size_t begin = std::min(i - std::min(i, used / 2), queries.size() - used);
    const std::vector<int32_t> query = cell_sequences(queries, begin, used);
    for (size_t j = 0; j < of_map.size(); ++j) {
      const auto information = dependence::directed_information_rate(
          query, of_map[j], options.memory, dependence::CountEntropyOptions::Estimator::kChaoShen);
      scores[j] = information.usable() ? information.value : 0;
    }
    out.push_back(best_of(scores, i - begin, options.neighbourhood));
  }
  return out;
}

}  // namespace infuse::places
