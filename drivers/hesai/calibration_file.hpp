#pragma once

#include <filesystem>
#include <string_view>

#include "drivers/hesai/calibration.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::hesai {

/// Parses an angle correction file as Hesai ships it with each unit: lines "channel,elevation,
/// azimuth", degrees, channels from 1, after a header line. All of the model's channels must be
/// there once. Errors: larger than 1 MiB, a missing or repeated channel, no number, an impossible
/// number; `where` is the line.
Result<Calibration> parse_angle_csv(std::string_view text, const ModelInfo& info);

/// Parses a file of at most 1 MiB.
Result<Calibration> load_angle_csv(const std::filesystem::path& path, const ModelInfo& info);

}  // namespace infuse::hesai
