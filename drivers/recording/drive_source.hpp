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

/// Stands for "no lidar of the rig sent this".
inline constexpr size_t kNoLidar = std::numeric_limits<size_t>::max();

/// A UDP datagram of a capture. `lidar` is an index into the rig, or `kNoLidar`.
struct DatagramEvent {
  size_t lidar = kNoLidar;
  Datagram datagram;
};

/// A decoded sweep of a source that has no packets. `lidar` is an index into the rig.
struct SweepEvent {
  size_t lidar = 0;
  const Sweep* sweep = nullptr;
};

/// A picture, not decoded yet. `camera` is an index into the rig; the event's stamp is the middle
/// of the exposure (`stamp_delay` is subtracted).
struct ImageEvent {
  size_t camera = 0;
  size_t sequence = 0;  ///< NNNNNN; gaps are lost frames
  const std::filesystem::path* path = nullptr;
};

/// A line of a candump log, as written, without its line end.
struct CanLineEvent {
  std::string_view line;
};

/// One thing that happened during a drive. What it points to is valid until the next event is asked
/// for.
struct DriveEvent {
  Stamp stamp;
  std::variant<DatagramEvent, SweepEvent, ImageEvent, CanLineEvent, ImuSample, GnssFix> content;
};

/// One recorded stream, in the order of its file.
class EventStream {
 public:
  virtual ~EventStream() = default;

  /// The next event, or false at the end. What the event points to is valid until the next call.
  virtual bool next(DriveEvent& event) = 0;

  /// Appends what was wrong so far: where a file ends early, which lines were skipped.
  virtual void append_notes(std::vector<Error>& notes) const = 0;
};

/// A drive, or a bare capture, as one stream in stamp order: the merge of its files. Streams whose
/// stamps are equal come in the order in which they were added; an event whose stamp lies before
/// the one handed out last (a clock that jumped) comes as soon as it is reached, and is counted.
/// Allocates nothing per event once the largest sweep has been seen.
class DriveSource {
 public:
  /// All streams of a drive: captures, sweeps, images, CAN, IMU, GPS.
  static Result<DriveSource> open(const Drive& drive);

  /// A bare capture; every datagram that passes the options is lidar 0's.
  static Result<DriveSource> open_capture(const std::filesystem::path& path,
                                          const PcapOptions& options = {});

  /// Adds a stream. Call before the first `next`.
  void add(std::unique_ptr<EventStream> stream);

  /// The next event in stamp order, or false at the end.
  bool next(DriveEvent& event);

  /// What was wrong so far in the files, to be shown to a person.
  std::vector<Error> notes() const;

  /// Events handed out whose stamp lay before the one handed out earlier.
  uint64_t out_of_order_count() const { return out_of_order_count_; }

 private:
  struct Input {
    std::unique_ptr<EventStream> stream;
    DriveEvent pending;
    bool has_pending = false;
  };
  void advance(Input& input) { input.has_pending = input.stream->next(input.pending); }

  std::vector<Input> inputs_;
  size_t current_input_ = kNoInput;  ///< whose pending event the caller holds
  Stamp last_stamp_ = Stamp::earliest();
  uint64_t out_of_order_count_ = 0;
  bool started_ = false;

  static constexpr size_t kNoInput = std::numeric_limits<size_t>::max();
};

}  // namespace infuse::recording
