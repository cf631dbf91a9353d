#include "fusion/watch/camera_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace infuse::watch {
namespace {

constexpr int kCoarse = 8;        // px between the pixels whose difference is coarse detail
constexpr float kSlow = 0.03F;    // how fast the usual is learned
constexpr float kVisible = 1.5F;  // grey levels; a cell with less usual detail tells nothing

uint64_t hash_of(const std::vector<uint8_t>& pixels) {
  uint64_t hash = 0xcbf29ce484222325U;
  size_t i = 0;
  for (; i + 8 <= pixels.size(); i += 8) {
    uint64_t word = 0;
    std::memcpy(&word, pixels.data() + i, 8);
    hash = (hash ^ word) * 0x100000001b3U;
    hash ^= hash >> 29;
  }
  for (; i < pixels.size(); ++i) hash = (hash ^ pixels[i]) * 0x100000001b3U;
  return hash;
}

}  // namespace

const char* to_string(CameraFault fault) {
  switch (fault) {
    case CameraFault::kNone:
      return "none";
    case CameraFault::kBlack:
      return "black";
    case CameraFault::kFrozen:
      return "frozen";
    case CameraFault::kDirty:
      return "dirty";
    case CameraFault::kOutOfFocus:
      return "out of focus";
    case CameraFault::kLate:
      return "late";
  }
  return "";
}

std::optional<std::string> CameraCheckOptions::invalid() const {
  if (!(black_level > 0) || !(black_spread > 0)) return "black_* must be positive";
  if (frozen_pictures < 2) return "frozen_pictures must be at least 2";
  for (const double share : {lost_detail, dirty_share, lost_focus}) {
    if (!(share > 0 && share < 1)) return "shares must lie in (0, 1)";
  }
  if (warm_up < 1 || sure < 1) return "warm_up and sure must be at least 1";
  return std::nullopt;
}

CameraCheck::CameraCheck(const CameraCheckOptions& options) : options_(options) {}

CameraCheck::Detail CameraCheck::measure(const CameraFrame& grey) {
  Detail detail;
  std::array<float, static_cast<size_t>(kColumns) * kRows> count{};
  double sum = 0;
  double squares = 0;
  double samples = 0;
  double fine = 0;
  for (int v = kCoarse; v < grey.height; v += 3) {
    const uint8_t* row =
        grey.pixels.data() + static_cast<size_t>(v) * static_cast<size_t>(grey.width);
    const uint8_t* above = row - static_cast<ptrdiff_t>(kCoarse) * grey.width;
    const size_t cells = static_cast<size_t>(v * kRows / grey.height) * kColumns;
    for (int u = kCoarse; u < grey.width; u += 3) {
      const int here = row[u];
      const auto coarse =
          static_cast<float>(std::abs(here - row[u - kCoarse]) + std::abs(here - above[u]));
      const size_t cell = cells + static_cast<size_t>(u * kColumns / grey.width);
      detail.cells[cell] += coarse;
      count[cell] += 1;
      detail.coarse += coarse;
      fine += std::abs(here - row[u - 1]);
      sum += here;
      squares += here * here;
      samples += 1;
    }
  }
  if (samples == 0) return detail;
  for (size_t k = 0; k < count.size(); ++k) detail.cells[k] /= std::max(1.0F, count[k]);
  detail.coarse /= static_cast<float>(samples);
  detail.fine = static_cast<float>(fine / samples);
  detail.mean = sum / samples;
  detail.spread = std::sqrt(std::max(0.0, squares / samples - detail.mean * detail.mean));
  return detail;
}

CameraFault CameraCheck::judge(const Detail& detail) const {
  if (detail.mean < options_.black_level && detail.spread < options_.black_spread) {
    return CameraFault::kBlack;
  }
  if (equal_ + 1 >= options_.frozen_pictures) return CameraFault::kFrozen;
  if (learned_ < options_.warm_up) return CameraFault::kNone;
  const float share = detail.fine / std::max(detail.coarse, 1e-3F);
  const float usual = usual_.fine / std::max(usual_.coarse, 1e-3F);
  if (share < static_cast<float>(options_.lost_focus) * usual) return CameraFault::kOutOfFocus;
  // The whole picture's contrast is taken out: dusk is no dirt.
  const float contrast = detail.coarse / std::max(usual_.coarse, 1e-3F);
  const float limit = static_cast<float>(options_.lost_detail) * std::min(1.0F, contrast);
  int blind = 0;
  int telling = 0;
  for (size_t k = 0; k < detail.cells.size(); ++k) {
    if (usual_.cells[k] < kVisible) continue;
    ++telling;
    blind += detail.cells[k] < limit * usual_.cells[k] ? 1 : 0;
  }
  if (telling > 0 && blind >= options_.dirty_share * telling) return CameraFault::kDirty;
  return CameraFault::kNone;
}

void CameraCheck::learn(const Detail& detail) {
  ++learned_;
  const float part = std::max(kSlow, 1.0F / static_cast<float>(learned_));
  const auto blend = [&](float& usual, float now) { usual += part * (now - usual); };
  for (size_t k = 0; k < usual_.cells.size(); ++k) blend(usual_.cells[k], detail.cells[k]);
  blend(usual_.coarse, detail.coarse);
  blend(usual_.fine, detail.fine);
}

CameraFault CameraCheck::take(const CameraFrame& grey, bool moving) {
  const uint64_t hash = hash_of(grey.pixels);
  equal_ = hash == hash_ ? equal_ + 1 : 0;
  hash_ = hash;
  const Detail detail = measure(grey);
  const CameraFault said = judge(detail);
  if (said == CameraFault::kNone && moving) learn(detail);
  times_ = said == said_ ? times_ + 1 : 1;
  said_ = said;
  // What a single picture shows for certain needs no second.
  if (times_ >= options_.sure || said == CameraFault::kFrozen) fault_ = said;
  return fault_;
}

}  // namespace infuse::watch
