#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/monitoring/camera_fault.hpp"
#include "fusion/monitoring/monitor_view.hpp"

namespace infuse::monitoring {

/// Settings of the camera check.
struct CameraCheckOptions {
  double black_level = 12;         ///< mean grey level of a black image: below this, and
  double black_sigma = 6;          ///< standard deviation below this
  int frozen_images = 3;           ///< consecutive equal images of a frozen camera
  double min_detail_ratio = 0.35;  ///< share of the usual detail below which a cell has lost it
  double dirty_share =
      0.15;  ///< share of the cells without detail over `dirty_distance`: dirty lens
  double dirty_distance = 48;  ///< m; what stays in place, or lacks detail, for so long is on the
                               ///< lens, or the lens itself
  double static_share = 0.28;  ///< share of the image in which a pattern stays in place over
                               ///< `dirty_distance`: dirty lens; over twice and three times this
                               ///< distance, a half and a third suffice
  double min_focus_ratio =
      0.6;                      ///< share of the usual sharpness of edges below which focus is lost
  int warm_up = 10;             ///< images before anything is reported: the baseline is learned
  int confirmation_images = 4;  ///< consecutive images with the same fault before it is reported

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Detects faults of a camera from its images alone: compares the detail in each cell of a 16 × 12
/// grid with its baseline.
///
/// Dirt does not move while the vehicle does, and a lens out of focus blurs whatever it passes,
/// which separates both from a wall or a plain sky over the driven distance. It is checked every
/// few metres by two signs: cells without detail, and blocks of a 64 × 48 grid that stay brighter,
/// or darker, than their surroundings. Scenery alternates; blots do not. Allocates nothing.
class CameraCheck {
 public:
  /// `options.invalid()` must be empty.
  explicit CameraCheck(const CameraCheckOptions& options);

  /// Processes the next image (kGrey8). `travelled`: m driven since the beginning.
  CameraFault process(const CameraFrame& grey, double travelled);

  CameraFault fault() const { return fault_; }

  static constexpr int kColumns = 16, kRows = 12;
  static constexpr int kBlockColumns = 4 * kColumns, kBlockRows = 4 * kRows;

 private:
  template <class Value>
  using PerCell = std::array<Value, static_cast<size_t>(kColumns) * kRows>;
  template <class Value>
  using PerBlock = std::array<Value, static_cast<size_t>(kBlockColumns) * kBlockRows>;
  struct Detail {
    PerCell<float> cells{};  ///< coarse, grey levels
    float coarse = 0;        // grey levels
    float sharpness = 0;     // of edges: share of their contrast in a pixel; 0: too little contrast
    double mean = 0, sigma = 0;
  };
  static Detail measure(const CameraFrame& grey);
  bool is_black(const Detail& detail) const;
  bool is_blurred(const Detail& detail) const;
  CameraFault classify(const Detail& detail) const;
  void update_baseline(const Detail& detail);
  void check_for_dirt(const CameraFrame& grey, const Detail& detail);
  void count_cells_without_detail(const Detail& detail);
  void count_static_blocks(const CameraFrame& grey);

  CameraCheckOptions options_;
  Detail baseline_;
  int baseline_images_ = 0;
  double baseline_updated_at_ = -1e9,
         dirt_checked_at_ = -1e9;             // m driven, at the last update and check
  PerCell<uint8_t> checks_without_detail_{};  // consecutive checks without detail
  PerBlock<uint8_t> checks_on_same_side_{};   // consecutive checks on the same side
  PerBlock<int8_t> side_{};                   // brighter or darker than its surroundings
  PerBlock<float> level_{};                   // scratch
  bool dirty_ = false;
  double sharp_at_ = 0, blurred_distance_ = 0;  // m driven, at the last sharp image and since
  uint64_t hash_ = 0;
  int equal_images_ = 0;
  CameraFault candidate_fault_ = CameraFault::kNone;  // of the last image
  int candidate_images_ = 0;                          // consecutive images with it
  CameraFault fault_ = CameraFault::kNone;
};

}  // namespace infuse::monitoring
