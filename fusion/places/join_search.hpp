#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "fusion/mapping/drive_join.hpp"
#include "fusion/places/place_index.hpp"

namespace infuse::places {

/// Settings of the search for places that two drives share.
struct JoinOptions {
  double spacing = 8;                 ///< m driven between two places that are compared
  size_t candidates = 3;              ///< places that look alike, of which each is verified
  double distinct = kDistinctPlaces;  ///< m driven between these
  /// Least that two places must have in common to be recognised without a guess.
  double min_agreement = 0.92, min_overlap = 0.45;
  size_t enough = 6;  ///< closures that agree; then no more are sought: bounds time
  mapping::AgreementOptions agreement;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Verifies a closure of which `from` and `to` are given, and the heading of `to` as seen from
/// `from` (rad) by the shapes of the places; fills the rest.
using VerifyPlaces = std::function<Result<void>(mapping::Closure&, double yaw)>;

/// What was found of one further drive.
struct JoinSearch {
  std::vector<mapping::Closure> tried;
  std::vector<size_t>
      agreeing;  ///< indices of `tried` (`find_agreeing`); empty if it does not join
};

/// Seeks places of a drive, the keyframes `first` to before `end`, among all before it: those that
/// look alike are verified, until enough closures agree or the drive ends. `descriptors` has an
/// entry for every keyframe, `first_keyframes` those of all drives. `options.invalid()` must be
/// empty.
Result<JoinSearch> search_join(const std::vector<mapping::Keyframe>& keyframes,
                               const std::vector<PlaceDescriptor>& descriptors,
                               const std::vector<size_t>& first_keyframes, size_t first, size_t end,
                               const JoinOptions& options, const VerifyPlaces& verify);

}  // namespace infuse::places
