#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "daemon/protocol/json.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::daemon {

// Members of JSON objects from files: what is absent or of another type is nothing, or empty.

/// The member; null if it is absent or `object` is no object.
const Json& field_of(const Json& object, const char* key);

/// The text of a member, at most 500 bytes of it; control characters are spaces.
std::string text_field(const Json& object, const char* key);

/// The finite number of a member.
std::optional<double> number_field(const Json& object, const char* key);

/// The whole number of a member.
std::optional<int64_t> integer_field(const Json& object, const char* key);

/// The rigid motion of a member: 16 numbers by row.
std::optional<Eigen::Isometry3d> motion_field(const Json& object, const char* key);

/// The symmetric matrix of a member: six rows of six finite numbers.
std::optional<geometry::Matrix6> matrix_field(const Json& object, const char* key);

}  // namespace infuse::daemon
