#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/receive/file_descriptor.hpp"
#include "drivers/receive/hardware_stamps.hpp"
#include "drivers/receive/message_batch.hpp"
#include "drivers/vehicle/bus_errors.hpp"
#include "drivers/vehicle/can_frame.hpp"

namespace infuse::vehicle {

/// Which bus is listened to, and for what.
struct SocketCanOptions {
  std::string interface = "can0";
  std::vector<CanIdentifier> identifiers;   ///< the kernel passes only these; empty: all
  size_t receive_buffer = size_t{1} << 20;  ///< bytes; a full bus of 1 Mbit/s fills 0.1 s of it

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// A CAN bus of this host, classic and FD.
class SocketCanSource {
 public:
  /// Errors: no such interface (yet), or it is no CAN bus. One that is down is waited for.
  static Result<SocketCanSource> open(const SocketCanOptions& options,
                                      const receive::TimeBase& base);

  /// Readable when something waits, and when the interface went down or away.
  int descriptor() const { return socket_.get(); }

  /// Takes what waits, at most `batch.capacity()` frames, and calls `on(const CanFrame&)` for each,
  /// error frames included. How many they were. An interface that went down is no error, see
  /// `up()`; one that is gone is: open another source, later.
  template <class OnFrame>
  Result<size_t> read(receive::MessageBatch& batch, OnFrame on) {
    const int count = batch.receive(socket_.get(), stamps_);
    if (count < 0) return handle_read_error();
    if (batch.dropped() != 0) dropped_ = batch.dropped();
    for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
      if (!process_message(batch[i])) continue;
      on(static_cast<const CanFrame&>(frame_));
    }
    return static_cast<size_t>(count);
  }

  /// Whether the interface is up; asks the kernel.
  bool up() const;

  /// What the controller has said of the bus.
  const BusErrors& bus_errors() const { return bus_errors_; }

  /// Frames that the kernel has dropped at this socket, as far as is known.
  uint64_t dropped() const { return dropped_; }

  /// Whether frames are stamped by the interface's own clock: where its driver tells that, else
  /// they have the kernel's stamp.
  bool stamped_by_hardware() const { return hardware_stamps_.stamped_by_hardware(); }

  const std::string& interface() const { return options_.interface; }

 private:
  SocketCanSource(const SocketCanOptions& options, const receive::TimeBase& base)
      : options_(options), stamps_(base) {}
  Result<void> set_up();
  bool process_message(const receive::MessageBatch::Message& message);
  Result<size_t> handle_read_error();

  SocketCanOptions options_;
  receive::WallStamps stamps_;
  receive::HardwareStamps hardware_stamps_;
  receive::FileDescriptor socket_;
  CanFrame frame_;
  BusErrors bus_errors_;
  uint64_t dropped_ = 0;
};

/// Room for one read of a bus.
inline receive::MessageBatch make_can_batch() { return receive::MessageBatch(64, 72); }

/// Reads a frame as SocketCAN hands it over: `struct can_frame` (16 bytes) or `canfd_frame` (72).
/// Sets everything but stamp and interface. False where the size is neither.
bool parse_socket_can(std::span<const uint8_t> bytes, CanFrame& frame);

}  // namespace infuse::vehicle
