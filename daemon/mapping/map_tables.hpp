#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "fusion/mapping/closure_search.hpp"

namespace infuse::daemon {

/// A keyframe of a map folder.
struct MapKeyframe {
  mapping::Keyframe keyframe;
  size_t points = 0;           ///< of its cloud; 0 where it has none
  std::string cloud_checksum;  ///< of the cloud's file; empty where it has none

  /// What is left where only the pose is kept.
  void drop_cloud() {
    keyframe.has_cloud = false;
    points = 0;
    cloud_checksum.clear();
  }
};

/// A GNSS fix, seen from the keyframe that is nearest in time.
struct MapFix {
  GnssFix fix;  ///< stamp, latitude, longitude, altitude, hdop
  size_t keyframe = 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< m, of the vehicle, in the keyframe's frame
};

/// Tables of a map folder as CSV text with a header, and back. Numbers have the digits that restore
/// them. Parsing fails with the line that is wrong: a header or number of columns that is not the
/// table's, a number that is not finite, keyframes that are not in order.
std::string format_keyframes(const std::vector<MapKeyframe>& keyframes);
Result<std::vector<MapKeyframe>> parse_keyframes(std::string_view text, const std::string& name);
std::string format_fixes(const std::vector<MapFix>& fixes);
Result<std::vector<MapFix>> parse_fixes(std::string_view text, const std::string& name);
std::string format_closures(const std::vector<mapping::Closure>& closures);
Result<std::vector<mapping::Closure>> parse_closures(std::string_view text,
                                                     const std::string& name);

}  // namespace infuse::daemon
