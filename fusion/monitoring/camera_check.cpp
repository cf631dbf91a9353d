#include "fusion/monitoring/camera_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace infuse::monitoring {
namespace {

constexpr int kCoarseDistance = 8;      // px between the pixels whose difference is coarse detail
constexpr float kBaselineRate = 0.03F;  // share of a new image in the baseline
constexpr float kMinBaselineDetail = 1.5F;    // grey levels; cells with less are not compared
constexpr double kMinBaselineDistance = 0.1;  // m between two images for the baseline
constexpr int kDirtChecks = 12;               // number of checks over `dirty_distance`
constexpr int kNeighbourBlocks = 5;           // blocks to each side of the surroundings
// Share of the pixels that lie beside a strong edge: one in 200. As many edges change the
// coarse detail of `kCoarseDistance` times as many pixels.
constexpr double kEdgeShare = 0.005;
// Grey levels of contrast of edges that are judged: rounding to whole levels changes their
// sharpness by an eighth at most.
constexpr double kMinEdge = 8;

/// Numbers of pixels by the size of a difference, grey levels.
using Differences = std::array<uint32_t, 256>;

/// The difference that a share of the pixels exceeds.
double exceeded_by(const Differences& differences, double share) {
  const double all = std::accumulate(differences.begin(), differences.end(), 0.0);
  double above = 0;
  size_t level = differences.size();
  while (level > 1 && above < share * all) above += differences[--level];
  return static_cast<double>(level);
}

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

std::optional<std::string> CameraCheckOptions::invalid() const {
  if (!(black_level > 0) || !(black_sigma > 0)) return "black_* must be positive";
  if (frozen_images < 2) return "frozen_images must be at least 2";
  for (const double share : {min_detail_ratio, dirty_share, static_share, min_focus_ratio}) {
    if (!(share > 0 && share < 1)) return "shares must be between 0 and 1";
  }
  if (!(dirty_distance > 0)) return "dirty_distance must be positive";
  if (warm_up < 1 || confirmation_images < 1)
    return "warm_up and confirmation_images must be at least 1";
  return std::nullopt;
}

CameraCheck::CameraCheck(const CameraCheckOptions& options) : options_(options) {}

CameraCheck::Detail CameraCheck::measure(const CameraFrame& grey) {
  Detail detail;
  std::array<float, static_cast<size_t>(kColumns) * kRows> count{};
  double sum = 0;
  double squares = 0;
  double samples = 0;
  Differences fine{}, across{};
  for (int v = kCoarseDistance; v < grey.height; v += 3) {
    const uint8_t* row =
        grey.pixels.data() + static_cast<size_t>(v) * static_cast<size_t>(grey.width);
    const uint8_t* above = row - static_cast<ptrdiff_t>(kCoarseDistance) * grey.width;
    const size_t cells = static_cast<size_t>(v * kRows / grey.height) * kColumns;
    for (int u = kCoarseDistance; u < grey.width; u += 3) {
      const int here = row[u];
      const auto coarse =
          static_cast<float>(std::abs(here - row[u - kCoarseDistance]) + std::abs(here - above[u]));
      const size_t cell = cells + static_cast<size_t>(u * kColumns / grey.width);
      detail.cells[cell] += coarse;
      count[cell] += 1;
      detail.coarse += coarse;
      ++fine[static_cast<size_t>(std::abs(here - row[u - 1]))];
      ++across[static_cast<size_t>(std::abs(here - row[u - kCoarseDistance]))];
      sum += here;
      squares += here * here;
      samples += 1;
    }
  }
  if (samples == 0) return detail;
  for (size_t k = 0; k < count.size(); ++k) detail.cells[k] /= std::max(1.0F, count[k]);
  detail.coarse /= static_cast<float>(samples);
  const double contrast = exceeded_by(across, kCoarseDistance * kEdgeShare);
  if (contrast >= kMinEdge)
    detail.sharpness = static_cast<float>(exceeded_by(fine, kEdgeShare) / contrast);
  detail.mean = sum / samples;
  detail.sigma = std::sqrt(std::max(0.0, squares / samples - detail.mean * detail.mean));
  return detail;
}

bool CameraCheck::is_black(const Detail& detail) const {
  return detail.mean < options_.black_level && detail.sigma < options_.black_sigma;
}

CameraFault CameraCheck::classify(const Detail& detail) const {
  if (is_black(detail)) return CameraFault::kBlack;
  if (equal_images_ + 1 >= options_.frozen_images) return CameraFault::kFrozen;
  if (baseline_images_ < options_.warm_up) return CameraFault::kNone;
  if (blurred_distance_ >= options_.dirty_distance) return CameraFault::kOutOfFocus;
  return dirty_ ? CameraFault::kDirty : CameraFault::kNone;
}

bool CameraCheck::is_blurred(const Detail& detail) const {
  return baseline_images_ >= options_.warm_up && detail.sharpness > 0 &&
         detail.sharpness < static_cast<float>(options_.min_focus_ratio) * baseline_.sharpness;
}

/// Counts consecutive checks of every cell without its usual detail. The contrast of the whole
/// image is divided out: dusk is not dirt.
void CameraCheck::count_cells_without_detail(const Detail& detail) {
  const float contrast = detail.coarse / std::max(baseline_.coarse, 1e-3F);
  const float limit = static_cast<float>(options_.min_detail_ratio) * std::min(1.0F, contrast);
  for (size_t k = 0; k < checks_without_detail_.size(); ++k) {
    const bool comparable = baseline_.cells[k] >= kMinBaselineDetail;
    const bool lost = comparable && detail.cells[k] < limit * baseline_.cells[k];
    checks_without_detail_[k] =
        lost ? static_cast<uint8_t>(std::min(checks_without_detail_[k] + 1, 255)) : uint8_t{0};
  }
}

/// Counts consecutive checks in which a block stays on the same side of the mean around it.
void CameraCheck::count_static_blocks(const CameraFrame& grey) {
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
    const int top = std::max(row - kNeighbourBlocks, 0),
              bottom = std::min(row + kNeighbourBlocks + 1, kBlockRows);
    for (int column = 0; column < kBlockColumns; ++column) {
      const int left = std::max(column - kNeighbourBlocks, 0);
      const int right = std::min(column + kNeighbourBlocks + 1, kBlockColumns);
      float sum = 0;
      for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x)
          sum += level_[static_cast<size_t>(y * kBlockColumns + x)];
      }
      const auto k = static_cast<size_t>(row * kBlockColumns + column);
      const float mean = sum / static_cast<float>((bottom - top) * (right - left));
      const int8_t side = level_[k] > mean ? 1 : -1;
      checks_on_same_side_[k] =
          side == side_[k] ? static_cast<uint8_t>(std::min(checks_on_same_side_[k] + 1, 255))
                           : uint8_t{1};
      side_[k] = side;
    }
  }
}

void CameraCheck::check_for_dirt(const CameraFrame& grey, const Detail& detail) {
  count_cells_without_detail(detail);
  count_static_blocks(grey);
  int blind = 0, comparable = 0;
  for (size_t k = 0; k < checks_without_detail_.size(); ++k) {
    comparable += baseline_.cells[k] >= kMinBaselineDetail ? 1 : 0;
    blind += checks_without_detail_[k] >= kDirtChecks ? 1 : 0;
  }
  // Dirt stays reported until half of it is gone.
  const double hysteresis = dirty_ ? 0.5 : 1;
  dirty_ = comparable > 0 && blind >= hysteresis * options_.dirty_share * comparable;
  for (int times = 1; times <= 3; ++times) {
    const auto static_blocks =
        std::count_if(checks_on_same_side_.begin(), checks_on_same_side_.end(),
                      [&](uint8_t checks) { return checks >= times * kDirtChecks; });
    const double share =
        static_cast<double>(static_blocks) / static_cast<double>(checks_on_same_side_.size());
    dirty_ = dirty_ || share >= hysteresis * options_.static_share / times;
  }
}

void CameraCheck::update_baseline(const Detail& detail) {
  ++baseline_images_;
  const float rate = std::max(kBaselineRate, 1.0F / static_cast<float>(baseline_images_));
  const auto blend = [&](float& baseline, float now) { baseline += rate * (now - baseline); };
  for (size_t k = 0; k < baseline_.cells.size(); ++k) blend(baseline_.cells[k], detail.cells[k]);
  blend(baseline_.coarse, detail.coarse);
  if (!(detail.sharpness > 0)) return;
  if (!(baseline_.sharpness > 0)) baseline_.sharpness = detail.sharpness;
  blend(baseline_.sharpness, detail.sharpness);
}

CameraFault CameraCheck::process(const CameraFrame& grey, double travelled) {
  const uint64_t hash = hash_of(grey.pixels);
  equal_images_ = hash == hash_ ? equal_images_ + 1 : 0;
  hash_ = hash;
  const Detail detail = measure(grey);
  const bool check_due = travelled - dirt_checked_at_ >= options_.dirty_distance / kDirtChecks;
  if (check_due && equal_images_ == 0 && baseline_images_ >= options_.warm_up &&
      !is_black(detail)) {
    check_for_dirt(grey, detail);
    dirt_checked_at_ = travelled;
  }
  const bool blurred = is_blurred(detail);
  if (!blurred) sharp_at_ = travelled;
  blurred_distance_ = travelled - sharp_at_;
  const CameraFault observed = classify(detail);
  if (observed == CameraFault::kNone && !blurred &&
      travelled - baseline_updated_at_ >= kMinBaselineDistance) {
    update_baseline(detail);
    baseline_updated_at_ = travelled;
  }
  candidate_images_ = observed == candidate_fault_ ? candidate_images_ + 1 : 1;
  candidate_fault_ = observed;
  // The other faults already are the result of many images.
  const bool immediate = observed != CameraFault::kNone && observed != CameraFault::kBlack;
  if (candidate_images_ >= options_.confirmation_images || immediate) fault_ = observed;
  return fault_;
}

}  // namespace infuse::monitoring
