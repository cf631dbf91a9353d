#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/host/file_descriptor.hpp"
#include "drivers/host/hardware_stamps.hpp"
#include "drivers/host/message_batch.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/vehicle/bus_errors.hpp"
#include "drivers/vehicle/can_frame.hpp"

namespace infuse::vehicle {

/// Bus and message filter.
struct SocketCanOptions {
  std::string interface = "can0";
  std::vector<CanIdentifier> identifiers;   ///< only these pass the kernel's filter; empty: all
  size_t receive_buffer = size_t{1} << 20;  ///< bytes; a full bus of 1 Mbit/s fills 0.1 s of it

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// A local CAN bus, classic and FD.
class SocketCanSource {
 public:
  /// Opens the bus. Errors: no such interface (yet), or not a CAN bus. An interface that is down is
  /// not an error; frames follow once it is up.
  static Result<SocketCanSource> open(const SocketCanOptions& options, const host::TimeBase& base);

  /// Readable when a frame is pending, and when the interface went down or away.
  int descriptor() const { return socket_.get(); }

  /// Reads pending frames, at most `batch.capacity()`, and calls `on(const CanFrame&)` for each,
  /// error frames included. Returns their number. An interface that went down is not an error, see
  /// `up()`; an error means that it is gone: open another source later.
  template <class OnFrame>
  Result<size_t> read(host::MessageBatch& batch, OnFrame on) {
    const int count = batch.receive(socket_.get(), stamps_);
    if (count < 0) return handle_read_error();
    if (batch.dropped() != 0) dropped_ = batch.dropped();
    for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
      if (!process_message(batch[i])) continue;
      on(static_cast<const CanFrame&>(frame_));
    }
    return static_cast<size_t>(count);
  }

  /// True if the interface is up; queries the kernel.
  bool up() const;

  /// State of the bus by its controller's error frames.
  const BusErrors& bus_errors() const { return bus_errors_; }

  /// Number of frames that the kernel has dropped at this socket, as far as known.
  uint64_t dropped() const { return dropped_; }

  /// True if frames have hardware stamps, if the interface's driver provides them; false if they
  /// have the kernel's stamps.
  bool stamped_by_hardware() const { return hardware_stamps_.stamped_by_hardware(); }

  const std::string& interface() const { return options_.interface; }

 private:
  SocketCanSource(const SocketCanOptions& options, const host::TimeBase& base)
      : options_(options), stamps_(base) {}
  Result<void> set_up();
  bool process_message(const host::MessageBatch::Message& message);
  Result<size_t> handle_read_error();

  SocketCanOptions options_;
  host::WallStamps stamps_;
  host::HardwareStamps hardware_stamps_;
  host::FileDescriptor socket_;
  CanFrame frame_;
  BusErrors bus_errors_;
  uint64_t dropped_ = 0;
};

/// Buffers for one read of a bus.
inline host::MessageBatch make_can_batch() { return host::MessageBatch(64, 72); }

/// Parses a frame of SocketCAN: `struct can_frame` (16 bytes) or `canfd_frame` (72). Sets
/// everything but stamp and interface. False for any other size.
bool parse_socket_can(std::span<const uint8_t> bytes, CanFrame& frame);

}  // namespace infuse::vehicle
