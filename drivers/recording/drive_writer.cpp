#include "drivers/recording/drive_writer.hpp"

#include <fcntl.h>
#include <unistd.h>

#include "drivers/gnss/gnss_csv.hpp"
#include "drivers/host/file_descriptor.hpp"
#include "drivers/recording/atomic_file.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "drivers/recording/numbered_files.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::recording {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxCopyBytes = 16 << 20;
constexpr fs::perms kFolderPermissions =
    fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec;
constexpr fs::perms kFilePermissions =
    fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read;

/// Sets permissions independently of the umask.
void set_permissions(const fs::path& path, fs::perms permissions) {
  std::error_code ignored;
  fs::permissions(path, permissions, ignored);
}

Result<void> create_folder(const fs::path& path) {
  std::error_code failed;
  if (!fs::create_directory(path, failed)) {
    return fail(failed ? "cannot be created: " + failed.message() : "already exists",
                path.string());
  }
  set_permissions(path, kFolderPermissions);
  return {};
}

Result<void> write_file(const fs::path& path, std::span<const uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (auto written = text::write_text(path, text); !written) return written;
  set_permissions(path, kFilePermissions);
  return {};
}

}  // namespace

Result<DriveWriter> DriveWriter::create(const fs::path& folder, const DriveDescription& description,
                                        const std::vector<CopiedFile>& copies) {
  if (const auto wrong = description.invalid()) return fail(*wrong, folder.string());
  if (const auto made = create_folder(folder); !made) return tl::unexpected(made.error());
  DriveWriter writer(folder, description);
  if (auto initialized = writer.write_initial_files(copies); !initialized) {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    return tl::unexpected(initialized.error());
  }
  return writer;
}

Result<void> DriveWriter::write_initial_files(const std::vector<CopiedFile>& copies) {
  for (const CopiedFile& file : copies) {
    if (auto copied = copy_file(file); !copied) return copied;
  }
  return create_files().and_then([&] { return flush(); }).and_then([&] {
    return write_description();
  });
}

Result<void> DriveWriter::create_files() {
  const auto append = [&](const std::string& name, const char* header) {
    return AppendFile::create(folder_ / name).map([&](AppendFile file) {
      file.add(header);
      return file;
    });
  };
  if (!description_.lidars.empty()) {
    const fs::path path = folder_ / description_.lidars.front().packets;
    auto packets = PcapWriter::create(path);
    if (!packets) return tl::unexpected(packets.error());
    set_permissions(path, kFilePermissions);
    packets_ = *std::move(packets);
  }
  for (const CameraFiles& camera : description_.cameras) {
    if (auto made = create_folder(folder_ / camera.images); !made) return made;
    auto times = append(camera.images + "/times.csv", "stamp_ns\n");
    if (!times) return tl::unexpected(times.error());
    cameras_.push_back({folder_ / camera.images, *std::move(times)});
  }
  if (description_.can) {
    auto can_log = append(description_.can->log, "");
    if (!can_log) return tl::unexpected(can_log.error());
    can_log_ = *std::move(can_log);
  }
  if (!description_.gnss.empty()) {
    auto gnss_log = append(description_.gnss, gnss::kGnssCsvHeader);
    if (!gnss_log) return tl::unexpected(gnss_log.error());
    gnss_log_ = *std::move(gnss_log);
  }
  return {};
}

Result<void> DriveWriter::copy_file(const CopiedFile& file) {
  const auto text = text::read_text(file.from, kMaxCopyBytes);
  if (!text) return tl::unexpected(text.error());
  image_bytes_ += text->size();
  return write_file(folder_ / file.to,
                    {reinterpret_cast<const uint8_t*>(text->data()), text->size()});
}

Result<void> DriveWriter::write_description() const {
  const std::string text = format_drive(description_);
  const fs::path path = folder_ / "drive.toml";
  auto written = write_file_atomically(path, std::as_bytes(std::span(text)));
  if (written) set_permissions(path, kFilePermissions);
  return written;
}

Result<void> DriveWriter::write_datagram(const Datagram& datagram) {
  return packets_ ? packets_->write(datagram) : Result<void>{};
}

void DriveWriter::write_can_line(std::string_view line) {
  if (!can_log_) return;
  can_log_->add(line);
  can_log_->add("\n");
}

void DriveWriter::write_gnss(const GnssFix& fix) {
  if (gnss_log_) gnss_log_->add(gnss::format_gnss_row(fix));
}

// The row is written after the file, because a reader ignores a file without a row.
Result<void> DriveWriter::write_image(size_t camera, Stamp stamp, uint64_t number,
                                      std::span<const uint8_t> file, const char* extension) {
  ImageFolder& image_folder = cameras_[camera];
  if (number < image_folder.rows || number - image_folder.rows > kMaxLostFrames)
    number = image_folder.rows;
  const fs::path path = image_folder.folder / numbered_file_name(number, extension);
  const fs::path temporary = path.string() + ".part";
  auto written = write_file(temporary, file);
  std::error_code failed;
  if (written) fs::rename(temporary, path, failed);
  if (!written || failed) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    return written ? fail("cannot be written: " + failed.message(), path.string()) : written;
  }
  image_bytes_ += file.size();
  // Rows of lost frames have no file; their stamp is meaningless.
  const std::string row = std::to_string(stamp.ns()) + '\n';
  for (; image_folder.rows <= number; ++image_folder.rows) image_folder.times.add(row);
  return {};
}

Result<void> DriveWriter::set_pixel_format(size_t camera, std::optional<PixelFormat> mosaic,
                                           bool grey) {
  CameraFiles& files = description_.cameras[camera];
  if (files.mosaic == mosaic && files.grey == grey) return {};
  files.mosaic = mosaic;
  files.grey = grey;
  return write_description();
}

Result<void> DriveWriter::flush() {
  if (packets_) {
    if (auto flushed = packets_->flush(); !flushed) return flushed;
  }
  if (can_log_) {
    if (auto flushed = can_log_->flush(); !flushed) return flushed;
  }
  if (gnss_log_) {
    if (auto flushed = gnss_log_->flush(); !flushed) return flushed;
  }
  for (ImageFolder& image_folder : cameras_) {
    if (auto flushed = image_folder.times.flush(); !flushed) return flushed;
  }
  return {};
}

void DriveWriter::sync() {
  const host::FileDescriptor folder(::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder) ::syncfs(folder.get());
}

uint64_t DriveWriter::bytes() const {
  uint64_t bytes = image_bytes_;
  if (packets_) bytes += packets_->bytes();
  if (can_log_) bytes += can_log_->bytes();
  if (gnss_log_) bytes += gnss_log_->bytes();
  for (const ImageFolder& image_folder : cameras_) bytes += image_folder.times.bytes();
  return bytes;
}

}  // namespace infuse::recording
