#include "daemon/record/recording.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/record/picture_file.hpp"
#include "drivers/vehicle/candump.hpp"

namespace infuse::daemon {
namespace {

template <class Plain>
Plain read_head(std::span<const uint8_t>& body) {
  Plain head;
  std::memcpy(&head, body.data(), sizeof(head));
  body = body.subspan(sizeof(head));
  return head;
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
  if (free && *free < plan.min_free) {
    return fail(fmt::format("only {} are free, and {} are to stay free", size_text(*free),
                            size_text(plan.min_free)),
                plan.directory.string(), "make room, or lower min_free_mb in [record]");
  }
  auto drive =
      recording::DriveWriter::create(plan.directory / plan.name, plan.description, plan.copies);
  if (!drive) return tl::unexpected(drive.error());
  Recording recording(std::move(plan), *std::move(drive));
  RecordReport& report = recording.report_;
  report.name = recording.plan_.name;
  report.folder = recording.drive_.folder().string();
  report.why = recording.plan_.why;
  report.stamp = report.since = now;
  report.drives = 1;
  return recording;
}

void Recording::take(const Record& record) {
  const Stamp stamp = record.stamp();
  if (report_.ended || stamp < plan_.from) return;
  if (stamp - plan_.until > kPatience) return end("");
  if (stamp > plan_.until) return;
  if (!first_) first_ = first_of_drive_ = stamp;
  if (stamp - *first_ > plan_.longest) return end("it is as long as it may be");
  report_.duration = std::max(report_.duration, stamp - *first_);
  const auto written = split_if_due(stamp).and_then([&] { return write(record); });
  if (!written) return end(written.error().message(), true);
  report_.bytes = bytes_before_ + drive_.bytes();
  if (report_.bytes >= plan_.largest) end("it is as large as it may be");
}

Result<void> Recording::write(const Record& record) {
  std::span<const uint8_t> body = record.body;
  switch (record.header.kind) {
    case RecordKind::kDatagram: {
      const auto head = read_head<DatagramHead>(body);
      ++report_.datagrams;
      return drive_.write(
          {record.stamp(), head.sender, head.sender_port, head.destination_port, body});
    }
    case RecordKind::kCanFrame:
      ++report_.frames;
      drive_.write_line(vehicle::format_candump_line(read_head<vehicle::CanFrame>(body)));
      return {};
    case RecordKind::kPicture:
      return write_picture(record);
    case RecordKind::kFix:
      ++report_.fixes;
      drive_.write(read_head<GpsFix>(body));
      return {};
  }
  return {};
}

// A picture that its camera damaged is a lost frame. The drive's stamps carry the camera's delay,
// which its reader subtracts.
Result<void> Recording::write_picture(const Record& record) {
  std::span<const uint8_t> body = record.body;
  const auto head = read_head<PictureHead>(body);
  const auto file = picture_file({head.format, head.width, head.height, head.row_bytes, body});
  if (!file) return {};
  const size_t camera = record.header.source;
  if (auto told = drive_.set_reading(camera, file->mosaic, file->grey); !told) return told;
  std::optional<uint64_t>& first = first_pictures_[camera];
  if (!first || head.sequence < *first) first = head.sequence;
  ++report_.pictures;
  const Stamp stamp = record.stamp() + plan_.description.rig.cameras[camera].stamp_delay;
  return drive_.write_picture(camera, stamp, head.sequence - *first, file->bytes, file->extension);
}

Result<void> Recording::split_if_due(Stamp stamp) {
  const bool long_enough =
      plan_.split != Duration::zero() && stamp - *first_of_drive_ > plan_.split;
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
  first_of_drive_ = stamp;
  first_pictures_.assign(first_pictures_.size(), std::nullopt);
  return {};
}

void Recording::look_after(Stamp now, uint64_t lost, bool caught_up) {
  if (report_.ended) return;
  report_.stamp = now;
  report_.lost = lost;
  flush(now);
  if (!report_.ended) check_bounds(now, caught_up);
}

void Recording::flush(Stamp now) {
  if (const auto flushed = drive_.flush(); !flushed) return end(flushed.error().message(), true);
  if (now - synced_ < kSyncPeriod) return;
  drive_.sync();
  synced_ = now;
}

void Recording::check_bounds(Stamp now, bool caught_up) {
  if (caught_up && now - plan_.until > kPatience) return end("");
  if (caught_up && !first_ && now - plan_.from > plan_.longest + kPatience) {
    return end("no sensor said anything");
  }
  const auto free = free_bytes(drive_.folder());
  if (!free || *free >= plan_.min_free) return;
  end(fmt::format("{}: only {} are free, and {} are to stay free", drive_.folder().string(),
                  size_text(*free), size_text(plan_.min_free)),
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
