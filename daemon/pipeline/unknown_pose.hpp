#pragma once

namespace infuse::daemon {

/// What is stated of a pose on a map while nothing is known of it.
inline constexpr double kUnknownSigma = 1e6;     ///< m
inline constexpr double kUnknownVariance = 1e6;  ///< m² and rad², of each axis

}  // namespace infuse::daemon
