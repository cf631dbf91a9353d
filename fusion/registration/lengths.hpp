#pragma once

namespace infuse::registration {

/// m; nearer returns are the vehicle's own.
inline constexpr double kMinRange = 2.5;

/// m, standard deviation of a range, by the manual of the HDL-32E.
inline constexpr double kRangeNoise = 0.02;

/// m, side of the voxels of a map, of which each keeps one point of a sweep (decision 17).
inline constexpr double kMapVoxelSize = 0.25;

/// m; farther returns are not part of a map.
inline constexpr double kMaxRange = 100;

/// Fewer points give no plane and how well they lie on it.
inline constexpr int kMinPlanePoints = 5;

/// m; residuals of points that are further apart are taken as independent.
inline constexpr double kClusterSize = 4;

/// Sine of the angle to the ray below which a plane is no surface but a beam's own cone: a surface
/// so near to edge-on meets one beam, where beams are 2° apart (manual of the VLP-16).
inline constexpr double kMinIncidence = 0.035;

/// m; a rotation counts as what it moves at this distance.
inline constexpr double kLever = 20;

}  // namespace infuse::registration
