#include "drivers/recording/drive_writer.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstring>

#include "drivers/recording/drive_toml.hpp"
#include "drivers/recording/mapped_file.hpp"
#include "drivers/recording/samples_csv.hpp"
#include "drivers/recording/text_file.hpp"

namespace infuse::recording {
namespace {

namespace fs = std::filesystem;

constexpr size_t kLargestCopy = 16 << 20;
constexpr fs::perms kFolder = fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec;
constexpr fs::perms kFile = fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read;

/// Readable by the group, whatever the umask.
void permit(const fs::path& path, fs::perms permissions) {
  std::error_code ignored;
  fs::permissions(path, permissions, ignored);
}

Result<void> make_folder(const fs::path& path) {
  std::error_code failed;
  if (!fs::create_directory(path, failed)) {
    return fail(failed ? "cannot be made: " + failed.message() : "is there already", path.string());
  }
  permit(path, kFolder);
  return {};
}

Result<void> write_file(const fs::path& path, std::span<const uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (auto written = write_text(path, text); !written) return written;
  permit(path, kFile);
  return {};
}

}  // namespace

Result<DriveWriter> DriveWriter::create(const fs::path& folder, const DriveDescription& description,
                                        const std::vector<Copy>& copies) {
  if (const auto wrong = description.invalid()) return fail(*wrong, folder.string());
  if (const auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  DriveWriter writer(folder, description);
  if (auto begun = writer.begin(copies); !begun) {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    return tl::unexpected(begun.error());
  }
  return writer;
}

Result<void> DriveWriter::begin(const std::vector<Copy>& copies) {
  for (const Copy& file : copies) {
    if (auto copied = copy(file); !copied) return copied;
  }
  return make_files().and_then([&] { return flush(); }).and_then([&] { return describe(); });
}

Result<void> DriveWriter::make_files() {
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
    permit(path, kFile);
    packets_ = *std::move(packets);
  }
  for (const CameraFiles& camera : description_.cameras) {
    if (auto made = make_folder(folder_ / camera.images); !made) return made;
    auto times = append(camera.images + "/times.csv", "stamp_ns\n");
    if (!times) return tl::unexpected(times.error());
    cameras_.push_back({folder_ / camera.images, *std::move(times)});
  }
  if (description_.can) {
    auto bus = append(description_.can->log, "");
    if (!bus) return tl::unexpected(bus.error());
    bus_ = *std::move(bus);
  }
  if (!description_.gps.empty()) {
    auto fixes = append(description_.gps, kGpsHeader);
    if (!fixes) return tl::unexpected(fixes.error());
    fixes_ = *std::move(fixes);
  }
  return {};
}

Result<void> DriveWriter::copy(const Copy& file) {
  const auto text = read_text(file.from, kLargestCopy);
  if (!text) return tl::unexpected(text.error());
  bytes_of_pictures_ += text->size();
  return write_file(folder_ / file.to,
                    {reinterpret_cast<const uint8_t*>(text->data()), text->size()});
}

Result<void> DriveWriter::describe() const {
  const std::string text = format_drive(description_);
  const fs::path path = folder_ / "drive.toml";
  auto written = write_whole(path, std::as_bytes(std::span(text)));
  if (written) permit(path, kFile);
  return written;
}

Result<void> DriveWriter::write(const Datagram& datagram) {
  return packets_ ? packets_->write(datagram) : Result<void>{};
}

void DriveWriter::write_line(std::string_view line) {
  if (!bus_) return;
  bus_->add(line);
  bus_->add("\n");
}

void DriveWriter::write(const GpsFix& fix) {
  if (fixes_) fixes_->add(gps_row(fix));
}

// The row follows the file: where the first is missing, the second is passed over by a reader.
Result<void> DriveWriter::write_picture(size_t camera, Stamp stamp, uint64_t number,
                                        std::span<const uint8_t> file, const char* extension) {
  Pictures& pictures = cameras_[camera];
  if (number < pictures.rows || number - pictures.rows > kMostLost) number = pictures.rows;
  char name[32];
  std::snprintf(name, sizeof(name), "%06llu", static_cast<unsigned long long>(number));
  const fs::path path = pictures.folder / (std::string(name) + extension);
  const fs::path beside = path.string() + ".part";
  auto written = write_file(beside, file);
  std::error_code failed;
  if (written) fs::rename(beside, path, failed);
  if (!written || failed) {
    std::error_code ignored;
    fs::remove(beside, ignored);
    return written ? fail("cannot be written: " + failed.message(), path.string()) : written;
  }
  bytes_of_pictures_ += file.size();
  // A lost frame's row has no file, and its time says nothing.
  const std::string row = std::to_string(stamp.ns()) + '\n';
  for (; pictures.rows <= number; ++pictures.rows) pictures.times.add(row);
  return {};
}

Result<void> DriveWriter::set_reading(size_t camera, std::optional<PixelFormat> mosaic, bool grey) {
  CameraFiles& files = description_.cameras[camera];
  if (files.mosaic == mosaic && files.grey == grey) return {};
  files.mosaic = mosaic;
  files.grey = grey;
  return describe();
}

Result<void> DriveWriter::flush() {
  if (packets_) {
    if (auto flushed = packets_->flush(); !flushed) return flushed;
  }
  if (bus_) {
    if (auto flushed = bus_->flush(); !flushed) return flushed;
  }
  if (fixes_) {
    if (auto flushed = fixes_->flush(); !flushed) return flushed;
  }
  for (Pictures& pictures : cameras_) {
    if (auto flushed = pictures.times.flush(); !flushed) return flushed;
  }
  return {};
}

void DriveWriter::sync() {
  const int folder = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  ::syncfs(folder);
  ::close(folder);
}

uint64_t DriveWriter::bytes() const {
  uint64_t bytes = bytes_of_pictures_;
  if (packets_) bytes += packets_->bytes();
  if (bus_) bytes += bus_->bytes();
  if (fixes_) bytes += fixes_->bytes();
  for (const Pictures& pictures : cameras_) bytes += pictures.times.bytes();
  return bytes;
}

}  // namespace infuse::recording
