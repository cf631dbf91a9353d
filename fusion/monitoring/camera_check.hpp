#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/monitoring/monitor_view.hpp"

namespace infuse::monitoring {

/// What is wrong with a camera by itself, its place aside.
enum class CameraFault : uint8_t {
  kNone,
  kBlack,       ///< nothing to be seen
  kFrozen,      ///< the same picture again and again, byte for byte
  kDirty,       ///< a part of the picture shows no detail any more
  kOutOfFocus,  ///< no fine detail anywhere, coarse detail as before
  kLate,        ///< its stamps are later than its exposures (`MonitorReport` says by how much)
};

/// "black", "frozen" …
const char* to_string(CameraFault fault);

/// Settings of the check.
struct CameraCheckOptions {
  double black_level = 12;         ///< mean grey level below which, with
  double black_sigma = 6;          ///< standard deviation below which, a picture shows nothing
  int frozen_images = 3;           ///< equal ones in a row
  double min_detail_ratio = 0.35;  ///< of what was usual: a cell with less shows nothing
  double dirty_share =
      0.15;  ///< of the cells without detail for `dirty_distance`: the lens is dirty
  double dirty_distance = 48;  ///< m; what stays in its place for so long is on the lens
  double static_share = 0.28;  ///< of the picture, in which a pattern stood still on
                               ///< `dirty_distance`: the lens is dirty; on twice and three times of
                               ///< it, a half and a third are enough
  double min_focus_ratio = 0.6;  ///< of the usual share of fine detail: out of focus
  int warm_up = 10;              ///< pictures from which the usual is learned
  int confirmation_images = 4;   ///< pictures in a row that must say the same

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Tells faults of a camera by its pictures alone, from one picture to the next: detail a cell of a
/// 16 × 12 grid against what was usual there.
///
/// Dirt is what does not move while the vehicle does, told from a wall or a plain sky by the way
/// driven. Two signs of it, looked at every few metres: cells that show no detail, and blocks of a
/// 64 × 48 grid that stay brighter, or darker, than what is around them. Scenery changes sides
/// again and again; blots do not. Allocates nothing.
class CameraCheck {
 public:
  /// `options.invalid()` must be empty.
  explicit CameraCheck(const CameraCheckOptions& options);

  /// Takes the next picture (kGrey8). `travelled`: m driven since the beginning.
  CameraFault process(const CameraFrame& grey, double travelled);

  CameraFault fault() const { return fault_; }

  static constexpr int kColumns = 16, kRows = 12;
  static constexpr int kBlockColumns = 64, kBlockRows = 48;

 private:
  template <class Value>
  using PerCell = std::array<Value, static_cast<size_t>(kColumns) * kRows>;
  template <class Value>
  using PerBlock = std::array<Value, static_cast<size_t>(kBlockColumns) * kBlockRows>;
  struct Detail {
    PerCell<float> cells{};  ///< coarse, grey levels
    float coarse = 0, fine = 0;
    double mean = 0, sigma = 0;
  };
  static Detail measure(const CameraFrame& grey);
  bool is_black(const Detail& detail) const;
  CameraFault classify(const Detail& detail) const;
  void update_baseline(const Detail& detail);
  void check_for_dirt(const CameraFrame& grey, const Detail& detail);
  void count_cells_without_detail(const Detail& detail);
  void count_static_blocks(const CameraFrame& grey);

  CameraCheckOptions options_;
  Detail baseline_;
  int baseline_images_ = 0;
  double baseline_updated_at_ = -1e9, dirt_checked_at_ = -1e9;  // m driven, at the last time
  PerCell<uint8_t> checks_without_detail_{};  // looks in a row without detail, by cell
  PerBlock<uint8_t> checks_on_same_side_{};   // looks in a row on the same side, by block
  PerBlock<int8_t> side_{};                   // of its surroundings: brighter or darker
  PerBlock<float> level_{};                   // scratch
  bool dirty_ = false;
  uint64_t hash_ = 0;
  int equal_images_ = 0;
  CameraFault candidate_fault_ = CameraFault::kNone;  // by the last picture
  int candidate_images_ = 0;                          // in a row
  CameraFault fault_ = CameraFault::kNone;
};

}  // namespace infuse::monitoring
