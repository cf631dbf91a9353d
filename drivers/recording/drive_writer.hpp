#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/recording/append_file.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/pcap_writer.hpp"

namespace infuse::recording {

/// Writes a drive while it happens. At every moment what is in the folder is a drive: files end
/// behind a whole record, pictures are there whole or not at all. Errors leave it so; what was
/// written since the last `flush` may then be missing.
class DriveWriter {
 public:
  /// A file that belongs to the drive: what names the signals of the bus, a lidar's beam table.
  struct CopiedFile {
    std::filesystem::path from;
    std::string to;  ///< in the drive
  };

  /// Makes the folder, which must not be there, and in it the files that the description names:
  /// one capture of all lidars, a folder for each camera, the bus's log and gps.csv.
  static Result<DriveWriter> create(const std::filesystem::path& folder,
                                    const DriveDescription& description,
                                    const std::vector<CopiedFile>& copies);

  /// A datagram of any lidar.
  Result<void> write_datagram(const Datagram& datagram);

  /// A line of the bus's log, without its end; nothing where the drive has no bus.
  void write_can_line(std::string_view line);

  /// A fix of the receiver; nothing where the drive has none.
  void write_gnss(const GnssFix& fix);

  /// A picture file. `number` is where it stands among this camera's, and grows: numbers left out
  /// are lost frames. `extension` with its dot: ".png" or ".jpg".
  Result<void> write_image(size_t camera, Stamp stamp, uint64_t number,
                           std::span<const uint8_t> file, const char* extension);

  /// How this camera's pictures are to be read, see `CameraFiles`. Rewrites drive.toml where that
  /// is new.
  Result<void> set_pixel_format(size_t camera, std::optional<PixelFormat> mosaic, bool grey);

  /// Hands everything to the system, so that the end of this process costs nothing of it.
  Result<void> flush();

  /// Brings everything to the disk, so that a power cut costs nothing of it. Takes its time.
  void sync();

  /// Of all files so far.
  uint64_t bytes() const;

  const std::filesystem::path& folder() const { return folder_; }

 private:
  static constexpr uint64_t kMaxLostFrames = 10'000;  // frames in a row; more is another count

  struct ImageFolder {
    std::filesystem::path folder;
    AppendFile times;
    uint64_t rows = 0;
  };

  DriveWriter(std::filesystem::path folder, DriveDescription description)
      : folder_(std::move(folder)), description_(std::move(description)) {}
  Result<void> write_initial_files(const std::vector<CopiedFile>& copies);
  Result<void> create_files();
  Result<void> copy_file(const CopiedFile& copy);
  Result<void> write_description() const;

  std::filesystem::path folder_;
  DriveDescription description_;
  std::optional<PcapWriter> packets_;
  std::vector<ImageFolder> cameras_;
  std::optional<AppendFile> can_log_, gnss_log_;
  uint64_t image_bytes_ = 0;  // and of copies
};

}  // namespace infuse::recording
