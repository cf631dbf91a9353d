#include "drivers/lidar/azimuth_repair.hpp"

#include "drivers/lidar/azimuth.hpp"

namespace infuse::lidar {
namespace {

/// The azimuths around a packet, by the index of its sequences: −1 is the one before.
struct Neighbours {
  std::span<const uint16_t> azimuths;
  std::optional<int> before, after;

  int count() const { return static_cast<int>(azimuths.size()); }
  std::optional<int> at(int i) const {
    if (i < 0) return i == -1 ? before : std::nullopt;
    if (i >= count()) return i == count() ? after : std::nullopt;
    const int azimuth = azimuths[static_cast<size_t>(i)];
    return azimuth == kNoAzimuth ? std::nullopt : std::optional<int>(azimuth);
  }
};

uint16_t wrapped(int azimuth) {
  return static_cast<uint16_t>((azimuth % kCentidegreesPerTurn + kCentidegreesPerTurn) %
                               kCentidegreesPerTurn);
}

bool is_rotation(int advance, int max_advance) { return advance >= 0 && advance <= max_advance; }

/// True if the sequence fits neither neighbour, but these fit each other.
bool is_stray(const Neighbours& all, int i, int max_step) {
  const auto before = all.at(i - 1);
  const auto now = all.at(i);
  const auto after = all.at(i + 1);
  if (!before || !now || !after) return false;
  return azimuth_advance(*before, *now) > max_step && azimuth_advance(*now, *after) > max_step &&
         is_rotation(azimuth_advance(*before, *after), 2 * max_step);
}

/// Linear between the nearest azimuths on both sides; on one side only, with the step there.
uint16_t interpolate(const Neighbours& all, int i, int max_step) {
  const int count = all.count();
  int low = i - 1;
  while (low >= -1 && !all.at(low)) --low;
  int high = i + 1;
  while (high <= count && !all.at(high)) ++high;
  const auto from = all.at(low);
  const auto to = all.at(high);
  if (from && to) {
    const int advance = azimuth_advance(*from, *to);
    if (is_rotation(advance, (high - low) * max_step)) {
      return wrapped(*from + advance * (i - low) / (high - low));
    }
  }
  const auto step = [&](int at, int next) {
    const auto a = all.at(at);
    const auto b = all.at(next);
    const int advance = a && b ? azimuth_advance(*a, *b) : 0;
    return is_rotation(advance, max_step) ? advance : 0;
  };
  if (from) return wrapped(*from + step(low - 1, low) * (i - low));
  return to ? wrapped(*to - step(high, high + 1) * (high - i)) : uint16_t{0};
}

}  // namespace

bool is_smooth(std::span<const uint16_t> azimuths, int before, int max_step) {
  const auto is_step = [&](int from, int to) {
    const int step = to - from;  // over north: negative
    return static_cast<unsigned>(step < 0 ? step + kCentidegreesPerTurn : step) <=
           static_cast<unsigned>(max_step);
  };
  if (azimuths[0] == kNoAzimuth) return false;
  bool smooth = is_step(before, azimuths[0]);
  for (size_t i = 1; i < azimuths.size(); ++i) {
    smooth &= is_step(azimuths[i - 1], azimuths[i]);
  }
  return smooth;
}

size_t repair_azimuths(std::span<uint16_t> azimuths, std::optional<int> before,
                       std::optional<int> after, int max_step) {
  if (after == kNoAzimuth) after.reset();
  const Neighbours all{azimuths, before, after};
  size_t repaired = 0;
  for (int i = 0; i < all.count(); ++i) {
    if (all.at(i) && !is_stray(all, i, max_step)) continue;
    azimuths[static_cast<size_t>(i)] = interpolate(all, i, max_step);
    ++repaired;
  }
  return repaired;
}

}  // namespace infuse::lidar
