#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/measurement/clock_state.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// Parameters of a ClockModel. The defaults fit a device that counts from the top of the hour.
struct ClockModelOptions {
  Duration modulo{3'600'000'000'000};  ///< ns; period of the device's counter; 0: it never wraps
  Duration min_delay{0};  ///< ns; minimum delay from the device's stamp to the host's (filling and
                          ///< sending the packet); passive observation cannot determine it
  double max_skew_ppm = 200;        ///< parts per million; maximum skew of the device's clock
  Duration window{60'000'000'000};  ///< ns; older samples are discarded
  /// Minimum time covered by samples before the model is trusted, ns.
  Duration settling_time{5'000'000'000};
  uint32_t min_samples = 40;           ///< minimum number of samples before the model is trusted
  Duration jump_threshold{5'000'000};  ///< ns; a sample further off is a jump candidate; a smaller
                                       ///< jump is absorbed within a window
  Duration jump_confirmation{500'000'000};  ///< ns; candidates that agree for this long, and are
                                            ///< not the known delays' chance, are a jump
  Duration max_delay{1'000'000'000};        ///< ns; maximum transport delay
  /// A counter further off the host's time (in its `modulo`) than this, ns, counts from power-up.
  Duration hour_tolerance{500'000'000};
  /// What the counter is, if it agrees with the host's time.
  ClockState::Source synchronised = ClockState::Source::kTopOfHour;

  /// Returns what is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;
};

/// Maps a device's time to host time from the arrival times of its messages: passive
/// synchronisation (P appendix C.2, after Olson 2010). A message is received after it was stamped,
/// and some messages are hardly delayed, so host time minus device time has a lower envelope: a
/// line whose slope is the skew of the two clocks. The model keeps the least delayed sample of each
/// of the window's 64 parts. It fits the envelope of these whenever a part is complete, and lowers
/// it at once for a sample below it.
///
/// The minimum transport delay cannot be observed: it is `min_delay`, or it remains in the result.
/// Deterministic; constant memory, no allocation, amortised O(1) per sample.
class ClockModel {
 public:
  /// Throws std::invalid_argument for options that are `invalid()`.
  explicit ClockModel(const ClockModelOptions& options);

  /// Adds a message stamped `device` by the device (time since its counter was 0) and received at
  /// `host`. Returns the host time of the device's stamp: at most `host` minus the minimum delay,
  /// and exactly that while the model does not hold (a jump not confirmed yet).
  Stamp update(Duration device, Stamp host);

  /// Returns the host time of a device time within half a `modulo` of the last sample's. Before the
  /// first sample, returns the device time itself.
  Stamp to_host(Duration device) const;

  /// States that the counter runs from the top of the hour, whatever the host's clock says: an NMEA
  /// sentence agrees with it. A jump of the counter ends this.
  void confirm_hour() { hour_confirmed_ = true; }

  /// State of the clock at the last sample.
  const ClockState& state() const { return state_; }

 private:
  static constexpr size_t kParts = 64;
  /// Minimum number of parts from which a skew is estimated.
  static constexpr size_t kMinPartsForSkew = 4;
  static constexpr uint32_t kMinJumpSamples = 3;

  /// Line of the envelope. Offsets are host time minus device time; device times are unwrapped: at
  /// the first sample and after a jump, the counter's time in the hour (modulo) that is nearest to
  /// the host's.
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
    double delay_sum_ns = 0;  ///< of all samples, above the envelope at that time
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
  /// Processes a sample that is off the model. True if it confirmed a jump.
  bool detect_jump(Duration device, Stamp host);
  /// True if the jump candidate may be samples that are delayed by chance.
  bool may_be_delay() const;
  void add_sample(Stamp device, Stamp host);
  void complete_part();
  void drop_oldest_part();
  void fit();
  void update_state(bool model_holds);

  ClockModelOptions options_;
  ClockState state_;
  bool started_ = false;
  bool hour_confirmed_ = false;
  Line line_;
  Stamp first_device_;  ///< of the first sample since the start or the last jump
  Stamp last_device_;   ///< of the latest sample
  uint64_t samples_ = 0;
  bool skew_at_limit_ = false;
  /// Number of latest parts in a row whose smallest delay lies above the envelope.
  uint32_t risen_parts_ = 0;
  Part part_;                         ///< the incomplete part
  std::array<Part, kParts> parts_{};  ///< complete parts, a ring
  size_t oldest_part_ = 0;
  size_t part_count_ = 0;
  JumpCandidate jump_candidate_;
};

}  // namespace infuse
