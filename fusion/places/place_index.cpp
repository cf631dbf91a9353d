#include "fusion/places/place_index.hpp"

#include <algorithm>
#include <numeric>

namespace infuse::places {

PlaceIndex::PlaceIndex(std::vector<PlaceDescriptor> places) : places_(std::move(places)) {
  for (const PlaceDescriptor& place : places_) keys_.push_back(key_of(place));
}

std::vector<PlaceCandidate> PlaceIndex::find(const PlaceDescriptor& query, size_t count) const {
  constexpr size_t kCompared = 8;  // times as many are compared in full (decision 17)
  const PlaceKey key = key_of(query);
  std::vector<float> products;
  for (const PlaceKey& other : keys_) products.push_back(key.dot(other));
  std::vector<size_t> order(places_.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const size_t compared = std::min(kCompared * count, order.size());
  const auto nearer = [&](size_t a, size_t b) {
    return products[a] != products[b] ? products[a] > products[b] : a < b;
  };
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(compared),
                    order.end(), nearer);
  std::vector<PlaceCandidate> out;
  for (size_t i = 0; i < compared; ++i) {
    out.push_back({order[i], compare_places(places_[order[i]], query)});
  }
  std::stable_sort(out.begin(), out.end(), [](const PlaceCandidate& a, const PlaceCandidate& b) {
    return a.similarity.correlation > b.similarity.correlation;
  });
  out.resize(std::min(out.size(), count));
  return out;
}

}  // namespace infuse::places
