#include "fusion/watch/camera_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace infuse::watch {
namespace {

constexpr int kCoarse = 8;        // px between the pixels whose difference is coarse detail
constexpr float kSlow = 0.03F;    // how fast the usual is learned
constexpr float kVisible = 1.5F;  // grey levels; a cell with less usual detail tells nothing
constexpr double kMoved = 0.1;    // m between two pictures that are learned from
constexpr int kLooks = 12;        // on `dirty_path`
constexpr int kAround = 5;        // blocks to each side that one is compared with

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
  for (const double share : {lost_detail, dirty_share, standing_share, lost_focus}) {
    if (!(share > 0 && share < 1)) return "shares must lie in (0, 1)";
  }
  if (!(dirty_path > 0)) return "dirty_path must be positive";
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

bool CameraCheck::black(const Detail& detail) const {
  return detail.mean < options_.black_level && detail.spread < options_.black_spread;
}

CameraFault CameraCheck::judge(const Detail& detail) const {
  if (black(detail)) return CameraFault::kBlack;
  if (equal_ + 1 >= options_.frozen_pictures) return CameraFault::kFrozen;
  if (learned_ < options_.warm_up) return CameraFault::kNone;
  const float share = detail.fine / std::max(detail.coarse, 1e-3F);
  const float usual = usual_.fine / std::max(usual_.coarse, 1e-3F);
  if (share < static_cast<float>(options_.lost_focus) * usual) return CameraFault::kOutOfFocus;
  return dirty_ ? CameraFault::kDirty : CameraFault::kNone;
}

/// Looks in a row of every cell without the detail that is usual there. The whole picture's
/// contrast is taken out: dusk is no dirt.
void CameraCheck::count_blind(const Detail& detail) {
  const float contrast = detail.coarse / std::max(usual_.coarse, 1e-3F);
  const float limit = static_cast<float>(options_.lost_detail) * std::min(1.0F, contrast);
  for (size_t k = 0; k < blind_.size(); ++k) {
    const bool telling = usual_.cells[k] >= kVisible;
    const bool lost = telling && detail.cells[k] < limit * usual_.cells[k];
    blind_[k] = lost ? static_cast<uint8_t>(std::min(blind_[k] + 1, 255)) : uint8_t{0};
  }
}

/// Looks in a row in which every block was on the same side of the mean around it.
void CameraCheck::count_standing(const CameraFrame& grey) {
  const int width = grey.width / kBlockColumns;
  const int height = grey.height / kBlockRows;
  if (width < 1 || height < 1) return;
  for (int row = 0; row < kBlockRows; ++row) {
    for (int column = 0; column < kBlockColumns; ++column) {
      uint32_t sum = 0;
      for (int v = row * height; v < (row + 1) * height; ++v) {
        const uint8_t* line =
            grey.pixels.data() + static_cast<size_t>(v) * static_cast<size_t>(grey.width);
        for (int u = column * width; u < (column + 1) * width; ++u) sum += line[u];
      }
      level_[static_cast<size_t>(row * kBlockColumns + column)] = static_cast<float>(sum);
    }
  }
  for (int row = 0; row < kBlockRows; ++row) {
    const int top = std::max(row - kAround, 0), bottom = std::min(row + kAround + 1, kBlockRows);
    for (int column = 0; column < kBlockColumns; ++column) {
      const int left = std::max(column - kAround, 0);
      const int right = std::min(column + kAround + 1, kBlockColumns);
      float sum = 0;
      for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x)
          sum += level_[static_cast<size_t>(y * kBlockColumns + x)];
      }
      const auto k = static_cast<size_t>(row * kBlockColumns + column);
      const float mean = sum / static_cast<float>((bottom - top) * (right - left));
      const int8_t side = level_[k] > mean ? 1 : -1;
      standing_[k] =
          side == side_[k] ? static_cast<uint8_t>(std::min(standing_[k] + 1, 255)) : uint8_t{1};
      side_[k] = side;
    }
  }
}

void CameraCheck::look_for_dirt(const CameraFrame& grey, const Detail& detail) {
  count_blind(detail);
  count_standing(grey);
  int blind = 0, telling = 0;
  for (size_t k = 0; k < blind_.size(); ++k) {
    telling += usual_.cells[k] >= kVisible ? 1 : 0;
    blind += blind_[k] >= kLooks ? 1 : 0;
  }
  // What was taken for dirt stays so until half of it is gone.
  const double held = dirty_ ? 0.5 : 1;
  dirty_ = telling > 0 && blind >= held * options_.dirty_share * telling;
  for (int times = 1; times <= 3; ++times) {
    const auto stood = std::count_if(standing_.begin(), standing_.end(),
                                     [&](uint8_t looks) { return looks >= times * kLooks; });
    const double share = static_cast<double>(stood) / static_cast<double>(standing_.size());
    dirty_ = dirty_ || share >= held * options_.standing_share / times;
  }
}

void CameraCheck::learn(const Detail& detail) {
  ++learned_;
  const float part = std::max(kSlow, 1.0F / static_cast<float>(learned_));
  const auto blend = [&](float& usual, float now) { usual += part * (now - usual); };
  for (size_t k = 0; k < usual_.cells.size(); ++k) blend(usual_.cells[k], detail.cells[k]);
  blend(usual_.coarse, detail.coarse);
  blend(usual_.fine, detail.fine);
}

CameraFault CameraCheck::take(const CameraFrame& grey, double travelled) {
  const uint64_t hash = hash_of(grey.pixels);
  equal_ = hash == hash_ ? equal_ + 1 : 0;
  hash_ = hash;
  const Detail detail = measure(grey);
  const bool look = travelled - looked_at_ >= options_.dirty_path / kLooks;
  if (look && equal_ == 0 && learned_ >= options_.warm_up && !black(detail)) {
    look_for_dirt(grey, detail);
    looked_at_ = travelled;
  }
  const CameraFault said = judge(detail);
  if (said == CameraFault::kNone && travelled - learned_at_ >= kMoved) {
    learn(detail);
    learned_at_ = travelled;
  }
  times_ = said == said_ ? times_ + 1 : 1;
  said_ = said;
  // What a single picture shows for certain, and what many together do, needs no second.
  const bool certain = said == CameraFault::kFrozen || said == CameraFault::kDirty;
  if (times_ >= options_.sure || certain) fault_ = said;
  return fault_;
}

}  // namespace infuse::watch
