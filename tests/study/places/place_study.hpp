#pragma once

#include <iosfwd>
#include <string>

#include "tests/study/places/true_map.hpp"

namespace infuse::study {

/// Starts of the localisation all along drives.
struct PlaceStudyOptions : VisitOptions {
  double spacing = 20;     ///< m between starts
  double max_way = 200;    ///< m after which a start is given up
  bool elsewhere = false;  ///< the drives are off the map
};

/// Starts a localiser from nothing every `spacing` m and follows it until it has tracked for 20 m;
/// prints a row per drive: starts on the map, of these found within 10 s and ever; starts off the
/// map (farther from every keyframe than the localiser looks); wrong of both (more than 1 m off,
/// relative to the nearest keyframe and its truth), errors. Returns an error text, or nothing.
std::string study_places(std::ostream& out, const PlaceStudyOptions& options);

}  // namespace infuse::study
