#pragma once

#include <cstdint>
#include <vector>

#include "fusion/places/image_descriptor.hpp"
#include "fusion/places/sequence_match.hpp"
#include "fusion/registration/visual/codebook.hpp"

namespace infuse::places {

/// Codewords of the cells of each image of a drive.
using CellWords = std::vector<std::vector<int32_t>>;

/// Learns codewords of the cells of a drive's images, by k-means. The images are of one size, and
/// `remove_common_view` has been applied.
registration::Codebook learn_cell_words(const std::vector<ImageDescriptor>& images, size_t words);

/// The codeword of every cell.
CellWords cell_words(const std::vector<ImageDescriptor>& images,
                     const registration::Codebook& codebook);

/// Settings of the matching by information.
struct SequenceInformationOptions {
  size_t length = SequenceMatchOptions{}.length;  ///< images of the query that are matched together
  int memory = 1;  ///< images before that the information is conditioned on; 0: mutual
  size_t neighbourhood =
      SequenceMatchOptions{}.neighbourhood;  ///< places beside the best that are not another answer
};

/// Finds each image of the query by the sequence about it: the places whose sequence of codewords
/// has the highest directed information P(6.1) with it, by Chao–Shen entropies; nats a step. Places
/// have to follow each other as the images of the query do: equal spacing. One answer per query.
std::vector<SequenceMatch> match_by_information(const CellWords& queries, const CellWords& places,
                                                const SequenceInformationOptions& options = {});

}  // namespace infuse::places
