#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/watch/quick_view.hpp"

namespace infuse::watch {

/// What is wrong with a camera by itself, its place aside.
enum class CameraFault : uint8_t {
  kNone,
  kBlack,       ///< nothing to be seen
  kFrozen,      ///< the same picture again and again, byte for byte
  kDirty,       ///< a part of the picture shows no detail any more
  kOutOfFocus,  ///< no fine detail anywhere, coarse detail as before
  kLate,        ///< its stamps are later than its exposures (`WatchReport` says by how much)
};

/// "black", "frozen" …
const char* to_string(CameraFault fault);

/// Settings of the check.
struct CameraCheckOptions {
  double black_level = 12;    ///< mean grey level below which, with
  double black_spread = 6;    ///< standard deviation below which, a picture shows nothing
  int frozen_pictures = 3;    ///< equal ones in a row
  double lost_detail = 0.35;  ///< of what was usual: a cell with less is blind
  double dirty_share = 0.15;  ///< of the cells blind: the lens is dirty
  double lost_focus = 0.6;    ///< of the usual share of fine detail: out of focus
  int warm_up = 10;           ///< pictures from which the usual is learned
  int sure = 4;               ///< pictures in a row that must say the same

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Tells faults of a camera by its pictures alone, from one picture to the next: detail a cell of a
/// 16 × 12 grid against what was usual there. Allocates nothing.
class CameraCheck {
 public:
  /// `options.invalid()` must be empty.
  explicit CameraCheck(const CameraCheckOptions& options);

  /// Takes the next picture (kGrey8). `moving`: the vehicle drives, so detail should change.
  CameraFault take(const CameraFrame& grey, bool moving);

  CameraFault fault() const { return fault_; }

  static constexpr int kColumns = 16, kRows = 12;

 private:
  struct Detail {
    std::array<float, static_cast<size_t>(kColumns) * kRows> cells{};  ///< coarse, grey levels
    float coarse = 0, fine = 0;
    double mean = 0, spread = 0;
  };
  static Detail measure(const CameraFrame& grey);
  CameraFault judge(const Detail& detail) const;
  void learn(const Detail& detail);

  CameraCheckOptions options_;
  Detail usual_;
  int learned_ = 0;
  uint64_t hash_ = 0;
  int equal_ = 0;
  CameraFault said_ = CameraFault::kNone;  // by the last picture
  int times_ = 0;                          // in a row
  CameraFault fault_ = CameraFault::kNone;
};

}  // namespace infuse::watch
