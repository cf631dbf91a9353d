#include "drivers/robosense/calibration.hpp"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <utility>

namespace infuse::robosense {
namespace {

// The files of angles that RoboSense publishes for its drivers, channel 1 first.

constexpr Calibration kHeliosAngles{
    {{{1494, -407},  {1303, 363},  {1092, -402},  {889, 360},   {696, -399},   {546, 358},
      {398, -398},   {267, 357},   {133, -397},   {0, 357},     {-133, -397},  {-267, 357},
      {-396, -398},  {-513, 358},  {-653, -399},  {-791, 359},  {-989, -401},  {-1597, 366},
      {-1290, -404}, {-1908, 370}, {-2202, -419}, {-2797, 388}, {-2516, -426}, {-3115, 397},
      {-3409, -452}, {-3729, 414}, {-4025, -476}, {-4371, 438}, {-4670, -503}, {-4975, 461},
      {-5270, -532}, {-5460, 480}}}};

constexpr Calibration kHelios16pAngles{{{{1494, -405},
                                         {1303, 361},
                                         {1092, -400},
                                         {890, 358},
                                         {696, -397},
                                         {546, 356},
                                         {398, -396},
                                         {267, 355},
                                         {133, -395},
                                         {0, 355},
                                         {-133, -395},
                                         {-267, 355},
                                         {-396, -396},
                                         {-523, 356},
                                         {-663, -397},
                                         {-801, 357}}}};

constexpr Calibration kBpearlV4Angles{
    {{{231, -3},   {4732, -67},  {512, -5},   {5013, -74},  {793, -9},   {5295, -81},
      {1074, -12}, {5577, -90},  {1355, -15}, {5859, -100}, {1635, -18}, {6140, -112},
      {1916, -21}, {6421, -127}, {2197, -25}, {6703, -145}, {2478, -28}, {6983, -167},
      {2759, -32}, {7264, -196}, {3041, -36}, {7544, -234}, {3322, -40}, {7825, -295},
      {3604, -45}, {8106, -450}, {3886, -49}, {8387, -671}, {4168, -55}, {8669, -1140},
      {4450, -60}, {8950, -5340}}}};

/// The manual of RS-Bpearl: 89.5° (channel 1), 7.9375° (31) and 2.3125° (32); each sixteen channels
/// are 5.625° apart.
constexpr Calibration bpearl_angles() {
  constexpr int kHighest = 89'500, kStep = 5'625;  // 0.001°
  Calibration calibration;
  for (size_t channel = 0; channel < kChannels; ++channel) {
    const int second = channel < 16 ? 0 : 1, place = static_cast<int>(channel % 16);
    const int elevation = kHighest - kStep * place - second * (kStep / 2);
    calibration.beams[channel].elevation = (elevation + 5) / 10;
  }
  return calibration;
}

constexpr Calibration kBpearlAngles = bpearl_angles();

}  // namespace

std::optional<std::string> Calibration::invalid(const ModelInfo& info) const {
  constexpr int kMaxElevation = 9000;
  for (size_t channel = 0; channel < info.lasers; ++channel) {
    const BeamAngles& beam = beams[channel];
    const std::string suffix = " of channel " + std::to_string(channel + 1) + " is out of range";
    if (std::abs(beam.elevation) >= kMaxElevation) return "elevation" + suffix;
    if (std::abs(beam.azimuth_offset) > info.max_azimuth_offset) return "azimuth" + suffix;
    const auto end = beams.begin() + static_cast<ptrdiff_t>(channel);
    if (std::find(beams.begin(), end, beam) != end) {
      return "channel " + std::to_string(channel + 1) + " has the direction of another";
    }
  }
  return std::nullopt;
}

std::array<uint16_t, kChannels> Calibration::rings(const ModelInfo& info) const {
  std::array<uint16_t, kChannels> by_elevation{};
  std::iota(by_elevation.begin(), by_elevation.end(), static_cast<uint16_t>(0));
  std::sort(by_elevation.begin(), by_elevation.begin() + info.lasers, [&](uint16_t a, uint16_t b) {
    return std::pair(beams[a].elevation, a) < std::pair(beams[b].elevation, b);
  });
  std::array<uint16_t, kChannels> rings{};
  for (uint16_t ring = 0; ring < info.lasers; ++ring) rings[by_elevation[ring]] = ring;
  return rings;
}

const Calibration& built_in_calibration(Model model) {
  switch (model) {
    case Model::kHelios:
      return kHeliosAngles;
    case Model::kHelios16p:
      return kHelios16pAngles;
    case Model::kBpearl:
      return kBpearlAngles;
    case Model::kBpearlV4:
      return kBpearlV4Angles;
  }
  return kHeliosAngles;
}

}  // namespace infuse::robosense
