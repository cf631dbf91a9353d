#include "drivers/import/bag_sinks.hpp"

#include <algorithm>

#include "drivers/camera/png_encoder.hpp"
#include "drivers/camera/raw_image.hpp"
#include "drivers/import/bag_cloud.hpp"
#include "drivers/import/image_size.hpp"
#include "drivers/makers/makers.hpp"
#include "drivers/recording/numbered_files.hpp"
#include "drivers/recording/sweep_export.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::importers {
namespace {

namespace fs = std::filesystem;

constexpr uint16_t kDataPort = 2368;
constexpr uint16_t kPositionPort = 8308;
constexpr uint32_t kLidarAddress = 0xC0A8'01C9;  // 192.168.1.201, as a lidar comes from the factory

Result<void> make_folder(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) return fail("cannot be created: " + failed.message(), folder.string());
  return {};
}

std::optional<camera::RawFormat> raw_format_of(const std::string& encoding) {
  using camera::RawFormat;
  static const std::map<std::string, RawFormat> kFormats = {{"mono8", RawFormat::kGrey},
                                                            {"8UC1", RawFormat::kGrey},
                                                            {"rgb8", RawFormat::kRgb24},
                                                            {"bgr8", RawFormat::kBgr24},
                                                            {"8UC3", RawFormat::kBgr24},
                                                            {"bayer_rggb8", RawFormat::kBayerRggb},
                                                            {"bayer_bggr8", RawFormat::kBayerBggr},
                                                            {"bayer_gbrg8", RawFormat::kBayerGbrg},
                                                            {"bayer_grbg8", RawFormat::kBayerGrbg},
                                                            {"yuv422", RawFormat::kUyvy},
                                                            {"yuv422_yuy2", RawFormat::kYuyv}};
  const auto found = kFormats.find(encoding);
  if (found == kFormats.end()) return std::nullopt;
  return found->second;
}

std::optional<PixelFormat> mosaic_of(camera::RawFormat format) {
  switch (format) {
    case camera::RawFormat::kBayerRggb:
      return PixelFormat::kBayerRggb8;
    case camera::RawFormat::kBayerBggr:
      return PixelFormat::kBayerBggr8;
    case camera::RawFormat::kBayerGbrg:
      return PixelFormat::kBayerGbrg8;
    case camera::RawFormat::kBayerGrbg:
      return PixelFormat::kBayerGrbg8;
    default:
      return std::nullopt;
  }
}

}  // namespace

Result<PacketSink> PacketSink::create(const fs::path& path) {
  auto writer = recording::PcapWriter::create(path);
  if (!writer) return tl::unexpected(writer.error());
  return PacketSink(std::move(*writer));
}

Result<void> PacketSink::write(Stamp stamp, uint16_t port, std::span<const uint8_t> payload) {
  ++packets_;
  return writer_.write({stamp, kLidarAddress, port, port, payload});
}

Result<void> PacketSink::write_positions(Stamp until) {
  while (!positions_.empty() && positions_.front().stamp < until) {
    const Position position = std::move(positions_.front());
    positions_.pop_front();
    if (auto done = write(position.stamp, kPositionPort, position.payload); !done) return done;
  }
  return {};
}

/// The first data packet shows the maker.
void PacketSink::infer(std::span<const uint8_t> payload) {
  const lidar::ClassifiedPacket packet = makers::classify(payload);
  if (packet.packet_class != lidar::PacketClass::kData) return;
  if (inference_ == nullptr) inference_ = packet.maker->make_inference();
  inference_->add(payload);
}

Result<void> PacketSink::add(std::span<const uint8_t> payload, Stamp stamp) {
  if (stamp < Stamp()) {
    skipped.add("has a packet from before 1970");
    return {};
  }
  if (auto done = write_positions(stamp); !done) return done;
  const lidar::PacketClass kind = makers::classify(payload).packet_class;
  const bool information = kind == lidar::PacketClass::kInformation;
  has_positions_ |= information;
  if (information || kind == lidar::PacketClass::kInertial) {
    return write(stamp, kPositionPort, payload);
  }
  infer(payload);
  return write(stamp, kDataPort, payload);
}

Result<void> PacketSink::add_position(std::span<const uint8_t> payload, Stamp log_time) {
  const lidar::PacketClass kind = makers::classify(payload).packet_class;
  if (kind != lidar::PacketClass::kInformation && kind != lidar::PacketClass::kInertial) {
    skipped.add("is not a position packet");
    return {};
  }
  has_positions_ |= kind == lidar::PacketClass::kInformation;
  positions_.push_back({log_time, {payload.begin(), payload.end()}});
  // Without scans there is nothing to wait for.
  constexpr size_t kMaxWaiting = 1000;
  return positions_.size() > kMaxWaiting ? write_positions(log_time) : Result<void>{};
}

Result<void> PacketSink::finish() {
  if (auto done = write_positions(Stamp::latest()); !done) return done;
  return writer_.close();
}

Result<CloudSink> CloudSink::create(const fs::path& folder) {
  if (auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  return CloudSink(folder);
}

Result<void> CloudSink::add(const ros::PointCloud2& cloud, Stamp stamp) {
  if (const auto read = to_sweep(cloud, stamp, sweep_); !read) {
    skipped.add(read.error().what);
    return {};
  }
  if (!sweep_.has_times) ++without_times_;
  const auto path = folder_ / recording::numbered_file_name(rows_.size(), ".pcd");
  if (auto done = recording::export_sweep(sweep_, path, recording::SweepFormat::kPcd); !done)
    return done;
  recording::TimesRow row{.stamp = sweep_.stamp};
  if (sweep_.has_times) row.end = sweep_.stamp + sweep_.span;
  rows_.push_back(row);
  return {};
}

Result<void> CloudSink::finish() { return recording::write_times(folder_ / "times.csv", rows_); }

Result<ImageSink> ImageSink::create(const fs::path& folder, const CameraIntrinsics& intrinsics) {
  if (auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  return ImageSink(folder, intrinsics.width, intrinsics.height);
}

Result<void> ImageSink::write(std::span<const uint8_t> file, const char* extension, Stamp stamp) {
  const auto path = folder_ / recording::numbered_file_name(stamps_.size(), extension);
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  if (auto done = text::write_text(path, text); !done) return done;
  const auto size = read_image_size(path);
  if (!size || size->width != width_ || size->height != height_) {
    std::error_code ignored;
    fs::remove(path, ignored);
    skipped.add(size ? "has another size than its camera_info states"
                     : "is neither a PNG nor a JPEG image");
    return {};
  }
  stamps_.push_back(stamp);
  return {};
}

Result<void> ImageSink::add(const ros::CompressedImage& image, Stamp stamp) {
  // "bayer_rggb8; png compressed bayer_rggb8": what was compressed.
  const auto format = raw_format_of(image.format.substr(0, image.format.find(';')));
  if (format) mosaic_ = mosaic_of(*format);
  const bool png = image.data.size() > 1 && image.data[0] == 0x89;
  return write(image.data, png ? ".png" : ".jpg", stamp);
}

Result<void> ImageSink::add(const ros::Image& image, Stamp stamp) {
  constexpr uint32_t kMaxSide = 65536;
  const auto format = raw_format_of(image.encoding);
  if (!format || image.width > kMaxSide || image.height > kMaxSide) {
    skipped.add("is in the encoding '" + image.encoding + "', which is not taken");
    return {};
  }
  const camera::RawImage raw{*format, static_cast<int>(image.width), static_cast<int>(image.height),
                             image.step, image.data};
  if (const auto unpacked = camera::unpack(raw, false, frame_); !unpacked) {
    skipped.add(unpacked.error().what);
    return {};
  }
  if (channels(frame_.format) == 1 && frame_.format != PixelFormat::kGrey8) {
    mosaic_ = frame_.format;
    frame_.format = PixelFormat::kGrey8;
  }
  const auto png = camera::encode_png(frame_);
  if (!png) {
    skipped.add(png.error().what);
    return {};
  }
  return write(*png, ".png", stamp);
}

Result<void> ImageSink::finish() { return recording::write_times(folder_ / "times.csv", stamps_); }

}  // namespace infuse::importers
