#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/sweep.hpp"
#include "drivers/velodyne/calibration.hpp"
#include "drivers/velodyne/model.hpp"
#include "drivers/velodyne/packet_counters.hpp"

namespace infuse::velodyne {

/// What a `SweepAssembler` is told.
struct SweepAssemblerOptions {
  Model model = Model::kHdl32e;
  std::optional<Calibration> calibration;  ///< of this unit; the model's own where absent
  double cut_azimuth = 0;  ///< °, as the sensor counts it (clockwise from the vendor's y, which
                           ///< is forward): where a sweep ends and the next begins, 0 … 360
  bool interpolate_azimuth = true;  ///< false: every return has its block's azimuth, as simple
                                    ///< viewers show it; wrong by up to 0.2°
  uint32_t sender = 0;  ///< IPv4 address of the sensor, host byte order; 0: whoever speaks first
  Duration max_span{400'000'000};  ///< ns: a sweep that lasts longer is ended (a sensor that does
                                   ///< not turn)

  /// What is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;
};

/// Turns the data packets of one sensor into sweeps, written straight into the `Sweep` that the
/// caller hands it: no copy, and no allocation once its arrays have grown to a sweep's size.
///
/// A packet is decoded when the next one has come, since only that tells the azimuth of its last
/// returns (and the time after a jump); so the assembler is one packet (0.2 … 1.4 ms) behind.
///
///     assembler.push(datagram);
///     while (assembler.pull(*sweep)) sweep = publish_and_take_an_empty_one(sweep);
///
/// A sweep runs from the cut azimuth to the cut azimuth, by the azimuth of blocks; where the sensor
/// looks at a part of the turn only, from its beginning to its end instead.
class SweepAssembler {
 public:
  /// The options must be valid.
  explicit SweepAssembler(const SweepAssemblerOptions& options);
  ~SweepAssembler();

  /// Takes a datagram of the data port. Whatever it holds: it is used, or counted with the reason.
  /// `pull` must have said false since the last push.
  void push(const Datagram& datagram);

  /// Decodes on into `sweep`. True: the sweep is complete, call again with an empty one. False: all
  /// that was pushed is in; hand the same sweep in again after the next push.
  bool pull(Sweep& sweep);

  /// The stream has ended: `pull` until false gives what is left.
  void finish();

  const PacketCounters& counters() const;
};

}  // namespace infuse::velodyne
