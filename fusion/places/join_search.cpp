#include "fusion/places/join_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace infuse::places {

std::optional<std::string> JoinOptions::invalid() const {
  if (!(spacing >= 0 && distinct >= 0)) return "lengths must not be negative";
  if (candidates < 1 || candidates > 100) return "candidates must be between 1 and 100";
  for (const double share : {min_agreement, min_overlap}) {
    if (!(share >= 0 && share <= 1)) return "shares must be between 0 and 1";
  }
  if (enough < agreement.min_closures) return "enough must not be less than min_closures";
  return agreement.invalid();
}

Result<JoinSearch> search_join(const std::vector<mapping::Keyframe>& keyframes,
                               const std::vector<PlaceDescriptor>& descriptors,
                               const std::vector<size_t>& first_keyframes, size_t first, size_t end,
                               const JoinOptions& options, const VerifyPlaces& verify) {
  std::vector<size_t> keyframe_of;  // by place of the index
  std::vector<PlaceDescriptor> earlier;
  for (size_t k = 0; k < first; ++k) {
    if (!keyframes[k].has_cloud) continue;
    keyframe_of.push_back(k);
    earlier.push_back(descriptors[k]);
  }
  const PlaceIndex index(std::move(earlier));
  JoinSearch search;
  // Distance driven at the next place that is compared.
  double next = -std::numeric_limits<double>::infinity();
  for (size_t k = first; k < end && search.agreeing.size() < options.enough; ++k) {
    if (keyframes[k].distance_driven < next || !keyframes[k].has_cloud) continue;
    next = keyframes[k].distance_driven + options.spacing;
    std::vector<size_t> tried;
    for (const PlaceCandidate& candidate :
         index.find(descriptors[k], kSearchedPerPlace * options.candidates)) {
      if (tried.size() == options.candidates) break;
      const size_t place = keyframe_of[candidate.place];
      const bool is_near = std::any_of(tried.begin(), tried.end(), [&](size_t other) {
        return std::abs(keyframes[other].distance_driven - keyframes[place].distance_driven) <
               options.distinct;
      });
      if (is_near) continue;
      tried.push_back(place);
      mapping::Closure closure;
      closure.from = place;
      closure.to = k;
      if (auto verified = verify(closure, candidate.similarity.yaw); !verified) {
        return tl::unexpected(verified.error());
      }
      const bool alike =
          closure.agreement >= options.min_agreement && closure.overlap >= options.min_overlap;
      if (closure.accepted() && !alike) closure.reason = "too little in common without a guess";
      search.tried.push_back(std::move(closure));
    }
    search.agreeing =
        mapping::find_agreeing(keyframes, first_keyframes, search.tried, options.agreement);
  }
  return search;
}

}  // namespace infuse::places
