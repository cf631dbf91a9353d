#pragma once

#include <array>
#include <string_view>
#include <utility>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::recording {

/// Names of camera models in drive.toml.
inline constexpr std::array<std::pair<std::string_view, CameraIntrinsics::Model>, 2> kCameraModels =
    {{{"pinhole", CameraIntrinsics::Model::kPinhole},
      {"fisheye", CameraIntrinsics::Model::kFisheye}}};

/// Names of Bayer patterns in drive.toml.
inline constexpr std::array<std::pair<std::string_view, PixelFormat>, 4> kMosaics = {
    {{"rggb", PixelFormat::kBayerRggb8},
     {"bggr", PixelFormat::kBayerBggr8},
     {"gbrg", PixelFormat::kBayerGbrg8},
     {"grbg", PixelFormat::kBayerGrbg8}}};

/// Values of `rotation` in drive.toml; true: clockwise, seen from above.
inline constexpr std::array<std::pair<std::string_view, bool>, 2> kRotations = {
    {{"clockwise", true}, {"counter-clockwise", false}}};

/// Values of `times` in drive.toml; true: the stamps can be trusted. "made up": earlier versions.
inline constexpr std::array<std::pair<std::string_view, bool>, 3> kTimes = {
    {{"recorded", true}, {"synthetic", false}, {"made up", false}}};

}  // namespace infuse::recording
