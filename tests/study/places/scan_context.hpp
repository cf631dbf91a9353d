#pragma once

#include "fusion/places/place_descriptor.hpp"

namespace infuse::study {

/// Similarity of two places by Scan Context (Kim and Kim 2018), the baseline: mean cosine of the
/// columns of the polar height maps at the best shift, over the columns that both have; 0 … 1.
double scan_context_similarity(const places::PlaceDescriptor& a, const places::PlaceDescriptor& b);

}  // namespace infuse::study
