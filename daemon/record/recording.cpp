#include "daemon/record/recording.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/record/image_file.hpp"
#include "drivers/vehicle/candump.hpp"

namespace infuse::daemon {
namespace {

template <class Plain>
Plain read_header(std::span<const uint8_t>& body) {
  Plain header;
  std::memcpy(&header, body.data(), sizeof(header));
  body = body.subspan(sizeof(header));
  return header;
}

std::string size_text(uint64_t bytes) {
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) * 1e-6);
}

}  // namespace

std::optional<uint64_t> free_bytes(const std::filesystem::path& folder) {
  std::error_code failed;
  const auto space = std::filesystem::space(folder, failed);
  return failed ? std::nullopt : std::optional<uint64_t>(space.available);
}

Result<Recording> Recording::begin(RecordingPlan plan, Stamp now) {
  const auto free = free_bytes(plan.directory);
  if (free && *free < plan.min_free_bytes) {
    return fail(
        fmt::format("only {} free, {} required", size_text(*free), size_text(plan.min_free_bytes)),
        plan.directory.string(), "free some space, or lower min_free_mb in [record]");
  }
  auto drive =
      recording::DriveWriter::create(plan.directory / plan.name, plan.description, plan.copies);
  if (!drive) return tl::unexpected(drive.error());
  Recording recording(std::move(plan), *std::move(drive));
  RecordReport& report = recording.report_;
  report.name = recording.plan_.name;
  report.folder = recording.drive_.folder().string();
  report.cause = recording.plan_.cause;
  report.stamp = report.since = now;
  report.drives = 1;
  return recording;
}

void Recording::add(const Record& record) {
  const Stamp stamp = record.stamp();
  if (report_.ended || stamp < plan_.from) return;
  if (stamp - plan_.until > kMaxRecordDelay) return end("");
  if (stamp > plan_.until) return;
  if (!first_stamp_) first_stamp_ = drive_begin_ = stamp;
  if (stamp - *first_stamp_ > plan_.max_duration) return end("maximum duration reached");
  report_.duration = std::max(report_.duration, stamp - *first_stamp_);
  const auto written = split_if_due(stamp).and_then([&] { return write(record); });
  if (!written) return end(written.error().message(), true);
  report_.bytes = bytes_before_ + drive_.bytes();
  if (report_.bytes >= plan_.max_bytes) end("maximum size reached");
}

Result<void> Recording::write(const Record& record) {
  std::span<const uint8_t> body = record.body;
  switch (record.header.kind) {
    case RecordKind::kDatagram: {
      const auto header = read_header<DatagramHeader>(body);
      ++report_.datagrams;
      return drive_.write_datagram(
          {record.stamp(), header.sender, header.sender_port, header.destination_port, body});
    }
    case RecordKind::kCanFrame:
      ++report_.frames;
      drive_.write_can_line(vehicle::format_candump_line(read_header<vehicle::CanFrame>(body)));
      return {};
    case RecordKind::kImage:
      return write_image(record);
    case RecordKind::kGnssFix:
      ++report_.fixes;
      drive_.write_gnss(read_header<GnssFix>(body));
      return {};
  }
  return {};
}

// An image that the camera damaged counts as a lost frame. The drive's stamps include the camera's
// delay, which the reader subtracts.
Result<void> Recording::write_image(const Record& record) {
  std::span<const uint8_t> body = record.body;
  const auto header = read_header<ImageHeader>(body);
  const auto file =
      encode_image_file({header.format, header.width, header.height, header.row_bytes, body});
  if (!file) return {};
  const size_t camera = record.header.source;
  if (auto set = drive_.set_pixel_format(camera, file->mosaic, file->grey); !set) return set;
  std::optional<uint64_t>& first = first_images_[camera];
  if (!first || header.sequence < *first) first = header.sequence;
  ++report_.images;
  const Stamp stamp = record.stamp() + plan_.description.rig.cameras[camera].stamp_delay;
  return drive_.write_image(camera, stamp, header.sequence - *first, file->bytes, file->extension);
}

Result<void> Recording::split_if_due(Stamp stamp) {
  const bool long_enough =
      plan_.split_duration != Duration::zero() && stamp - *drive_begin_ > plan_.split_duration;
  const bool large_enough = plan_.split_bytes != 0 && drive_.bytes() >= plan_.split_bytes;
  if (!long_enough && !large_enough) return {};
  if (auto flushed = drive_.flush(); !flushed) return flushed;
  const std::string name = fmt::format("{}.{}", plan_.name, report_.drives + 1);
  auto next =
      recording::DriveWriter::create(plan_.directory / name, plan_.description, plan_.copies);
  if (!next) return tl::unexpected(next.error());
  bytes_before_ += drive_.bytes();
  drive_ = *std::move(next);
  ++report_.drives;
  drive_begin_ = stamp;
  first_images_.assign(first_images_.size(), std::nullopt);
  return {};
}

void Recording::flush_and_check(Stamp now, uint64_t lost, bool caught_up) {
  if (report_.ended) return;
  report_.stamp = now;
  report_.lost = lost;
  flush(now);
  if (!report_.ended) check_bounds(now, caught_up);
}

void Recording::flush(Stamp now) {
  if (const auto flushed = drive_.flush(); !flushed) return end(flushed.error().message(), true);
  if (now - last_sync_ < kSyncPeriod) return;
  drive_.sync();
  last_sync_ = now;
}

void Recording::check_bounds(Stamp now, bool caught_up) {
  if (caught_up && now - plan_.until > kMaxRecordDelay) return end("");
  if (caught_up && !first_stamp_ && now - plan_.from > plan_.max_duration + kMaxRecordDelay) {
    return end("no sensor data arrived");
  }
  const auto free = free_bytes(drive_.folder());
  if (!free || *free >= plan_.min_free_bytes) return;
  end(fmt::format("{}: only {} free, {} required", drive_.folder().string(), size_text(*free),
                  size_text(plan_.min_free_bytes)),
      true);
}

void Recording::end(const std::string& reason, bool failed) {
  if (report_.ended) return;
  report_.ended = true;
  report_.failed = failed;
  report_.reason = reason;
  if (const auto flushed = drive_.flush(); !flushed && !failed) {
    report_.failed = true;
    report_.reason = flushed.error().message();
  }
  drive_.sync();
}

}  // namespace infuse::daemon
