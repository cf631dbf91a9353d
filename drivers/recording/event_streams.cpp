#include "drivers/recording/event_streams.hpp"

#include <algorithm>

#include "drivers/gnss/gnss_csv.hpp"
#include "drivers/recording/capture_reader.hpp"
#include "drivers/recording/imu_csv.hpp"
#include "drivers/recording/speed_csv.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "drivers/recording/times_csv.hpp"
#include "drivers/text/line_reader.hpp"
#include "drivers/text/stamp_text.hpp"

namespace infuse::recording {
namespace {

void append(std::vector<Error>& notes, const std::vector<Error>& more) {
  notes.insert(notes.end(), more.begin(), more.end());
}

// Stamp at the beginning of a candump line: "(1436509052.249713) …".
std::optional<Stamp> parse_candump_stamp(std::string_view line) {
  line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  const size_t end = line.find(')');
  if (!line.starts_with('(') || end == std::string_view::npos) return std::nullopt;
  return text::parse_stamp(line.substr(1, end - 1));
}

class CaptureStream : public EventStream {
 public:
  CaptureStream(CaptureReader reader, std::vector<LidarRoute> routes)
      : reader_(std::move(reader)), routes_(std::move(routes)) {}

  bool next(DriveEvent& event) override {
    DatagramEvent datagram;
    if (!reader_.next(datagram.datagram)) return false;
    datagram.lidar = find_lidar(datagram.datagram);
    event.stamp = datagram.datagram.stamp;
    event.content = datagram;
    return true;
  }

  void append_notes(std::vector<Error>& notes) const override { reader_.append_notes(notes); }

 private:
  size_t find_lidar(const Datagram& datagram) const {
    if (routes_.empty()) return 0;
    for (const LidarRoute& route : routes_) {
      const bool port = datagram.destination_port == route.port ||
                        datagram.destination_port == route.position_port;
      if (port && route.sender.value_or(datagram.sender) == datagram.sender) return route.lidar;
    }
    return kNoLidar;
  }

  CaptureReader reader_;
  std::vector<LidarRoute> routes_;
};

class SweepStream : public EventStream {
 public:
  SweepStream(FileSequence sequence, size_t lidar, const LidarFiles& files, bool times_trusted)
      : files_(std::move(sequence)),
        lidar_(lidar),
        turn_(files.turn),
        deskewed_(files.deskewed),
        times_trusted_(times_trusted) {
    uintmax_t largest = 0;
    for (const SequenceEntry& entry : files_.entries) {
      std::error_code failed;
      const uintmax_t size = std::filesystem::file_size(entry.path, failed);
      if (!failed) largest = std::max(largest, size);
    }
    constexpr uintmax_t kMaxPoints = (64 << 20) / 16;  // maximum of SweepReader
    reader_.reserve(static_cast<size_t>(std::min(largest / 16, kMaxPoints)), sweep_);
  }

  bool next(DriveEvent& event) override {
    while (next_index_ < files_.entries.size()) {
      const SequenceEntry& entry = files_.entries[next_index_++];
      if (const auto read = reader_.read(entry.path, sweep_); !read) {
        if (unreadable_++ == 0) first_error_ = read.error();
        continue;
      }
      sweep_.stamp = entry.stamp;
      sweep_.span = times_trusted_ ? entry.span : Duration::zero();
      assign_times();
      sweep_.sequence = entry.number;
      sweep_.clock.trusted = times_trusted_;
      sweep_.clock.reason = times_trusted_ ? "" : "the drive's times are synthetic";
      event.stamp = sweep_.stamp + sweep_.span;
      event.content = SweepEvent{lidar_, &sweep_};
      return true;
    }
    return false;
  }

  void append_notes(std::vector<Error>& notes) const override {
    append(notes, files_.notes);
    if (unreadable_ > 0) {
      notes.push_back(first_error_);
      notes.back().hint = std::to_string(unreadable_) + " such sweeps were skipped";
    }
  }

 private:
  void assign_times() {
    if (!times_trusted_) sweep_.has_times = false;
    if (sweep_.has_times) {  // the file's own; a turn that is stated lasts at least as long
      for (const int32_t offset : sweep_.time_offset_ns)
        sweep_.span = std::max(sweep_.span, Duration(offset));
    }
    if (deskewed_) {
      assign_middle_time(sweep_);
    } else if (turn_ && sweep_.span > Duration::zero()) {
      assign_turn_times(*turn_, sweep_);
    }
  }

  FileSequence files_;
  size_t lidar_;
  std::optional<Turn> turn_;
  bool deskewed_;
  bool times_trusted_;
  size_t next_index_ = 0;
  SweepReader reader_;
  Sweep sweep_;
  size_t unreadable_ = 0;
  Error first_error_;
};

class ImageStream : public EventStream {
 public:
  ImageStream(FileSequence files, size_t camera) : files_(std::move(files)), camera_(camera) {}

  bool next(DriveEvent& event) override {
    if (next_index_ == files_.entries.size()) return false;
    const SequenceEntry& entry = files_.entries[next_index_++];
    event.stamp = entry.stamp;
    event.content = ImageEvent{camera_, entry.number, &entry.path};
    return true;
  }

  void append_notes(std::vector<Error>& notes) const override { append(notes, files_.notes); }

 private:
  FileSequence files_;
  size_t camera_;
  size_t next_index_ = 0;
};

class CanStream : public EventStream {
 public:
  CanStream(text::LineReader lines, std::string file)
      : lines_(std::move(lines)), file_(std::move(file)) {}

  bool next(DriveEvent& event) override {
    std::string_view line;
    while (lines_.next(line)) {
      if (line.empty()) continue;
      const auto stamp = parse_candump_stamp(line);
      if (!stamp) {
        if (malformed_lines_++ == 0) first_malformed_line_ = lines_.line_number();
        continue;
      }
      event.stamp = *stamp;
      event.content = CanLineEvent{line};
      return true;
    }
    return false;
  }

  void append_notes(std::vector<Error>& notes) const override {
    if (malformed_lines_ > 0) {
      notes.push_back({"does not begin with a time such as '(1436509052.249713)'",
                       file_ + ":" + std::to_string(first_malformed_line_),
                       std::to_string(malformed_lines_) + " such lines were skipped"});
    }
    if (lines_.too_long_lines() > 0) {
      notes.push_back(
          {std::to_string(lines_.too_long_lines()) + " overlong lines were skipped", file_, {}});
    }
  }

 private:
  text::LineReader lines_;
  std::string file_;
  uint64_t malformed_lines_ = 0;
  uint64_t first_malformed_line_ = 0;
};

// `Csv` is SpeedCsv, ImuCsv or gnss::GnssCsv, `Sample` the type that it reads.
template <class Csv, class Sample>
class SampleStream : public EventStream {
 public:
  explicit SampleStream(Csv csv, Duration delay = Duration::zero())
      : csv_(std::move(csv)), delay_(delay) {}

  bool next(DriveEvent& event) override {
    Sample sample;
    if (!csv_.next(sample)) return false;
    sample.stamp = sample.stamp - delay_;
    event.stamp = sample.stamp;
    event.content = sample;
    return true;
  }

  void append_notes(std::vector<Error>& notes) const override { csv_.append_notes(notes); }

 private:
  Csv csv_;
  Duration delay_;
};

}  // namespace

Result<std::unique_ptr<EventStream>> open_capture_stream(const std::filesystem::path& path,
                                                         const PcapOptions& options,
                                                         std::vector<LidarRoute> routes) {
  auto reader = CaptureReader::open(path, options);
  if (!reader) return tl::unexpected(reader.error());
  return std::make_unique<CaptureStream>(std::move(*reader), std::move(routes));
}

Result<std::unique_ptr<EventStream>> open_sweep_stream(const std::filesystem::path& folder,
                                                       size_t lidar, const LidarFiles& files,
                                                       bool times_trusted) {
  auto sequence = index_sweeps(folder);
  if (!sequence) return tl::unexpected(sequence.error());
  return std::make_unique<SweepStream>(std::move(*sequence), lidar, files, times_trusted);
}

Result<std::unique_ptr<EventStream>> open_image_stream(const std::filesystem::path& folder,
                                                       size_t camera, Duration stamp_delay) {
  auto files = index_images(folder, stamp_delay);
  if (!files) return tl::unexpected(files.error());
  return std::make_unique<ImageStream>(std::move(*files), camera);
}

Result<std::unique_ptr<EventStream>> open_can_stream(const std::filesystem::path& path) {
  auto lines = text::LineReader::open(path);
  if (!lines) return tl::unexpected(lines.error());
  return std::make_unique<CanStream>(std::move(*lines), path.string());
}

Result<std::unique_ptr<EventStream>> open_speed_stream(const std::filesystem::path& path) {
  auto csv = SpeedCsv::open(path);
  if (!csv) return tl::unexpected(csv.error());
  return std::make_unique<SampleStream<SpeedCsv, WheelOdometry>>(std::move(*csv));
}

Result<std::unique_ptr<EventStream>> open_imu_stream(const std::filesystem::path& path,
                                                     Duration delay) {
  auto csv = ImuCsv::open(path);
  if (!csv) return tl::unexpected(csv.error());
  return std::make_unique<SampleStream<ImuCsv, ImuSample>>(std::move(*csv), delay);
}

Result<std::unique_ptr<EventStream>> open_gnss_stream(const std::filesystem::path& path) {
  auto csv = gnss::GnssCsv::open(path);
  if (!csv) return tl::unexpected(csv.error());
  return std::make_unique<SampleStream<gnss::GnssCsv, GnssFix>>(std::move(*csv));
}

}  // namespace infuse::recording
