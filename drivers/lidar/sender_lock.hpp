#pragma once

#include <array>
#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse::lidar {

/// Decides from which address a lidar sends, if it is not configured: the first sender is used,
/// until it has been silent for `kSilence`, or sends less than a sensor while another one sends as
/// much as a sensor. A single forged packet so costs at most `kWindow` of data, and a unit that was
/// exchanged for one with another address is found.
class SenderLock {
 public:
  /// Silence after which another sender is used.
  static constexpr Duration kSilence{2'000'000'000};
  /// Time over which the packets of the senders are counted.
  static constexpr Duration kWindow{2'000'000'000};
  /// Packets per second of a sensor: a Velodyne sends at least 750, of which many may be lost.
  static constexpr double kSensorPacketsHz = 100;

  /// `configured`: IPv4 address of the sensor, host byte order, which is kept for ever; 0: none.
  explicit SenderLock(uint32_t configured) : sender_(configured), configured_(configured != 0) {}

  /// True if a datagram from `sender` is certainly not used: its bytes need not be read.
  bool refuses(uint32_t sender) const { return configured_ && sender != sender_; }

  /// Takes note of a valid packet, and returns true if it is to be used.
  bool accept(uint32_t sender, Stamp stamp);

  /// Address of the sender in use; 0: none yet.
  uint32_t sender() const { return sender_; }
  /// Address used before; 0: none.
  uint32_t previous() const { return previous_; }
  /// Number of times that another sender was taken.
  uint64_t changes() const { return changes_; }
  /// Another sender that sent as many packets as a sensor in the last window; 0: none.
  uint32_t rival() const { return rival_; }

 private:
  struct Candidate {
    uint32_t sender = 0;
    uint32_t packets = 0;
  };

  void count_other(uint32_t sender);
  void end_window(Stamp stamp);
  void take(uint32_t sender, Stamp stamp);
  void start_window(Stamp stamp);

  uint32_t sender_;
  bool configured_;
  uint32_t previous_ = 0;
  uint32_t rival_ = 0;
  uint64_t changes_ = 0;
  Stamp last_packet_ = Stamp::earliest();  // of the sender in use
  Stamp window_start_ = Stamp::earliest();
  uint64_t packets_ = 0;  // of the sender in use, in this window
  /// Others in this window, counted as Misra and Gries do: who sends more than a ninth of their
  /// packets is among them, however many addresses are forged.
  std::array<Candidate, 8> others_{};
};

}  // namespace infuse::lidar
