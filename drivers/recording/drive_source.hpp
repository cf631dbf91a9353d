#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/sweep.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/pcap_reader.hpp"

namespace infuse::recording {

/// Index of a datagram that no lidar of the rig has sent.
inline constexpr size_t kNoLidar = std::numeric_limits<size_t>::max();

/// A UDP datagram of a capture. `lidar` is an index into `Rig::lidars`, or `kNoLidar`.
struct DatagramEvent {
  size_t lidar = kNoLidar;  ///< the sender
  Datagram datagram;        ///< with its stamp
};

/// A sweep of a lidar whose files contain decoded sweeps. `lidar` is an index into `Rig::lidars`.
/// The event's stamp is the end of the sweep.
struct SweepEvent {
  size_t lidar = 0;              ///< whose sweep
  const Sweep* sweep = nullptr;  ///< not null
};

/// An image file, not decoded yet. `camera` is an index into `Rig::cameras`. The event's stamp is
/// the middle of the exposure (`stamp_delay` is subtracted).
struct ImageEvent {
  size_t camera = 0;                            ///< whose image
  size_t sequence = 0;                          ///< number of the file; gaps are lost frames
  const std::filesystem::path* path = nullptr;  ///< not null
};

/// A line of a candump log, without its line end.
struct CanLineEvent {
  std::string_view line;  ///< as in the log
};

/// One recorded measurement with its stamp. Pointers and spans are valid until the next event is
/// read.
struct DriveEvent {
  Stamp stamp;  ///< of the measurement
  std::variant<DatagramEvent, SweepEvent, ImageEvent, CanLineEvent, WheelOdometry, ImuSample,
               GnssFix>
      content;  ///< what it is
};

/// One recorded stream, in file order.
class EventStream {
 public:
  virtual ~EventStream() = default;

  /// Reads the next event; pointers and spans in it are valid until the next call. Returns false at
  /// the end.
  virtual bool next(DriveEvent& event) = 0;

  /// Appends the problems found so far, such as a truncated file or skipped lines.
  virtual void append_notes(std::vector<Error>& notes) const = 0;
};

/// Merges the files of a drive, or a bare capture, into one stream in stamp order. Events with
/// equal stamps are ordered by their streams, in the order in which these were added. An event
/// whose stamp is earlier than that of the previous event (after a clock step) is returned as soon
/// as it is reached, and counted. Allocates nothing per event after the largest sweep has been
/// read.
class DriveSource {
 public:
  /// Opens all streams of a drive: captures, sweeps, images, CAN, speed, IMU, GNSS.
  static Result<DriveSource> open(const Drive& drive);

  /// Opens a bare capture; every datagram that passes the filter belongs to lidar 0.
  static Result<DriveSource> open_capture(const std::filesystem::path& path,
                                          const PcapOptions& options = {});

  /// Adds a stream. Call before the first `next`.
  void add(std::unique_ptr<EventStream> stream);

  /// Reads the next event in stamp order. Returns false at the end.
  bool next(DriveEvent& event);

  /// Returns the problems found so far in the files, for display.
  std::vector<Error> notes() const;

  /// Number of events whose stamp was earlier than that of the previous event.
  uint64_t out_of_order_count() const { return out_of_order_count_; }

 private:
  struct Input {
    std::unique_ptr<EventStream> stream;
    DriveEvent pending;
    bool has_pending = false;
  };
  void advance(Input& input) { input.has_pending = input.stream->next(input.pending); }

  std::vector<Input> inputs_;
  size_t current_input_ = kNoInput;  ///< input whose pending event was returned last
  Stamp last_stamp_ = Stamp::earliest();
  uint64_t out_of_order_count_ = 0;
  bool started_ = false;

  static constexpr size_t kNoInput = std::numeric_limits<size_t>::max();
};

}  // namespace infuse::recording
