#include "drivers/lidar/decoder_options.hpp"

namespace infuse::lidar {

std::optional<std::string> DecoderOptions::invalid() const {
  if (!(cut_azimuth >= -360 && cut_azimuth <= 360)) {
    return "cut_azimuth must be in -360 ... 360 degrees";
  }
  if (max_span < Duration(50'000'000) || max_span > Duration(2'000'000'000)) {
    return "max_span must be in 0.05 ... 2 s";
  }
  return std::nullopt;
}

}  // namespace infuse::lidar
