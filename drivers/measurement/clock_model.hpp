#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/measurement/clock_state.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// How a device's clock is followed. The defaults are those of a Velodyne, which counts from the
/// top of the hour.
struct ClockModelOptions {
  Duration modulo{3'600'000'000'000};  ///< ns; the device's counter starts again here; 0: never
  Duration min_delay{0};      ///< ns; from the device's stamp to the host's at best (to fill and
                              ///< send the packet): passive observation cannot tell it
  double max_skew_ppm = 200;  ///< parts per million; no device's clock is worse
  Duration window{60'000'000'000};        ///< ns; what is older is forgotten
  Duration settling_time{5'000'000'000};  ///< ns; not trusted before samples cover so much time,
  uint32_t min_samples = 40;              ///< and not before there are so many
  Duration jump_threshold{5'000'000};     ///< ns; a sample so far off is suspect; a smaller jump is
                                          ///< absorbed within a window
  Duration jump_confirmation{500'000'000};  ///< ns; suspects that agree for so long are a jump
  Duration max_delay{1'000'000'000};        ///< ns; no transport takes longer
  Duration hour_tolerance{500'000'000};     ///< ns; a counter so far off the host's hour is said to
                                            ///< count from power-up

  /// What is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;
};

/// Maps a device's time to host time by watching when its messages arrive: passive synchronisation
/// (P appendix C.2, after Olson 2010). A message is received after it was stamped, never before,
/// and some are hardly delayed: so host time minus device time has a lower envelope, a line whose
/// slope is the skew of the two clocks. The samples of a window are thinned to the least delayed
/// one of each of its 64 parts; the envelope of these is taken whenever a part is complete, and
/// lowered at once by a sample that lies below it.
///
/// What cannot be observed is the least transport delay itself: it is `min_delay`, or it
/// remains in the result. Deterministic; constant memory, no allocation, amortised O(1) a sample.
class ClockModel {
 public:
  /// Options that are `invalid()` are a programming error.
  explicit ClockModel(const ClockModelOptions& options);

  /// Takes a message stamped `device` by the device (time since its counter was 0) and received at
  /// `host`, and returns the host's time of the device's stamp: not later than `host` less the
  /// minimum delay, and that itself where the model does not hold (a jump not confirmed yet).
  Stamp update(Duration device, Stamp host);

  /// The host's time of a device time within half a `modulo` of the last sample's. Before the first
  /// sample, device time itself.
  Stamp to_host(Duration device) const;

  /// As of the last sample.
  const ClockState& state() const { return state_; }

 private:
  static constexpr size_t kParts = 64;
  /// Fewer parts than this say nothing of the skew.
  static constexpr size_t kMinPartsForSkew = 4;
  static constexpr uint32_t kMinJumpSamples = 3;

  /// Offsets are host time minus device time; device times are unwrapped: at the first sample and
  /// after a jump, the counter's time in the hour (modulo) that is nearest to the host's.
  struct Line {
    Stamp device;
    Duration offset{0};
    double slope = 0;
  };
  /// The least delayed sample of a part of the window.
  struct Part {
    Stamp begin{};
    Stamp device{};
    Duration offset{0};
    double delay_sum_ns = 0;  ///< of all samples, above the envelope of that time
    uint32_t samples = 0;
  };
  /// Samples that disagree with the model but agree with each other.
  struct JumpCandidate {
    uint32_t count = 0;
    Stamp since;
    Duration offset{0};
  };

  Duration offset_at(Stamp device) const;
  Stamp unwrap(Duration device, Stamp expected) const;
  void restart(Stamp device, Duration offset);
  /// Takes a sample that is off the model. True where it confirmed a jump.
  bool detect_jump(Duration device, Stamp host);
  void add_sample(Stamp device, Stamp host);
  void complete_part();
  void drop_oldest_part();
  void fit();
  void update_state(bool model_holds);

  ClockModelOptions options_;
  ClockState state_;
  bool started_ = false;
  Line line_;
  Stamp first_device_;  ///< of the first sample since the start or the last jump
  Stamp last_device_;   ///< of the latest
  uint64_t samples_ = 0;
  bool skew_at_limit_ = false;
  uint32_t risen_parts_ = 0;  ///< of the latest, those whose least delay lies above the envelope
  Part part_;                 ///< being filled
  std::array<Part, kParts> parts_{};  ///< complete ones, a ring
  size_t oldest_part_ = 0;
  size_t part_count_ = 0;
  JumpCandidate jump_candidate_;
};

}  // namespace infuse
