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

/// Writes a drive during recording. The folder is a valid drive at any time, also after an error:
/// files end after a whole record and images are complete. After an error, data written since the
/// last `flush` may be missing.
class DriveWriter {
 public:
  /// A file to copy into the drive, such as a DBC file or a beam table.
  struct CopiedFile {
    std::filesystem::path from;  ///< the file
    std::string to;              ///< relative to the drive
  };

  /// Creates the folder, which must not exist, and the files that the description names: one
  /// capture for all lidars, a folder for each camera, the CAN log and gnss.csv.
  static Result<DriveWriter> create(const std::filesystem::path& folder,
                                    const DriveDescription& description,
                                    const std::vector<CopiedFile>& copies);

  /// Writes a datagram of any lidar.
  Result<void> write_datagram(const Datagram& datagram);

  /// Writes a line of the CAN log, given without its end. Does nothing if the drive has no CAN log.
  void write_can_line(std::string_view line);

  /// Writes a GNSS fix. Does nothing if the drive has no GNSS file.
  void write_gnss(const GnssFix& fix);

  /// Writes an image file. `number` is the frame number of this camera and increases; skipped
  /// numbers are lost frames. `extension` includes the dot: ".png" or ".jpg".
  Result<void> write_image(size_t camera, Stamp stamp, uint64_t number,
                           std::span<const uint8_t> file, const char* extension);

  /// Sets `CameraFiles::mosaic` and `CameraFiles::grey` of a camera. Rewrites drive.toml if they
  /// change.
  Result<void> set_pixel_format(size_t camera, std::optional<PixelFormat> mosaic, bool grey);

  /// Writes all buffered data to the files, so that it survives the end of this process.
  Result<void> flush();

  /// Writes all files to the disk (syncfs), so that they survive a power cut. Blocks.
  void sync();

  /// Number of bytes in all files.
  uint64_t bytes() const;

  const std::filesystem::path& folder() const { return folder_; }  ///< the drive

 private:
  static constexpr uint64_t kMaxLostFrames =
      10'000;  // larger gaps mean that the numbering restarted

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
  uint64_t image_bytes_ = 0;  // of images and copied files
};

}  // namespace infuse::recording
