#include "tests/study/places/scan_context.hpp"

#include <algorithm>
#include <array>

namespace infuse::study {

double scan_context_similarity(const places::PlaceDescriptor& a, const places::PlaceDescriptor& b) {
  constexpr int kColumns = places::kSectors;
  std::array<float, kColumns> norm_a{}, norm_b{};
  for (int k = 0; k < kColumns; ++k) {
    norm_a[static_cast<size_t>(k)] = a.heights.col(k).norm();
    norm_b[static_cast<size_t>(k)] = b.heights.col(k).norm();
  }
  double best = 0;
  for (int shift = 0; shift < kColumns; ++shift) {
    double sum = 0;
    int count = 0;
    for (int k = 0; k < kColumns; ++k) {
      const int other = (k + shift) % kColumns;
      const float norms = norm_a[static_cast<size_t>(other)] * norm_b[static_cast<size_t>(k)];
      if (!(norms > 0)) continue;
      sum += static_cast<double>(a.heights.col(other).dot(b.heights.col(k)) / norms);
      ++count;
    }
    if (count > 0) best = std::max(best, sum / count);
  }
  return best;
}

}  // namespace infuse::study
