#include "daemon/owner/inspection.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>

#include "daemon/command_line/lidar_problems.hpp"
#include "daemon/owner/drive_uses.hpp"
#include "daemon/pipeline/replay.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/recording/capture_parts.hpp"
#include "drivers/recording/capture_reader.hpp"

namespace infuse::daemon {
namespace {

Result<RecordingContents> survey_capture(const std::filesystem::path& path) {
  auto reader = recording::CaptureReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  RecordingContents contents;
  Datagram datagram;
  while (reader->next(datagram)) contents.survey.add(datagram);
  contents.survey.set_packets(reader->counters());
  reader->append_notes(contents.notes);
  return contents;
}

std::string kind_of(const recording::DriveEvent& event) {
  if (const auto* image = std::get_if<recording::ImageEvent>(&event.content)) {
    return fmt::format("images of camera {}", image->camera);
  }
  if (const auto* sweep = std::get_if<recording::SweepEvent>(&event.content)) {
    return fmt::format("decoded sweeps of lidar {}", sweep->lidar);
  }
  if (std::holds_alternative<recording::CanLineEvent>(event.content)) return "CAN frames";
  if (std::holds_alternative<WheelOdometry>(event.content)) return "speeds";
  return std::holds_alternative<GnssFix>(event.content) ? "GNSS fixes" : "IMU samples";
}

Result<RecordingContents> survey_drive(const std::filesystem::path& path) {
  const auto drive = recording::Drive::open(path);
  if (!drive) return tl::unexpected(drive.error());
  auto source = recording::DriveSource::open(*drive);
  if (!source) return tl::unexpected(source.error());
  RecordingContents contents;
  recording::DriveEvent event;
  while (source->next(event)) {
    if (const auto* datagram = std::get_if<recording::DatagramEvent>(&event.content)) {
      contents.survey.add(datagram->datagram);
    } else {
      contents.other_streams[kind_of(event)].add(event.stamp);
    }
  }
  contents.notes = source->notes();
  contents.has_map = !drive->description.map.empty();
  return contents;
}

/// Raises the level of each lidar to that of its problems: health needs seconds to judge, and a
/// capture may be shorter.
Summary judge_lidars(Summary summary) {
  Totals& totals = summary.totals;
  for (const auto& [id, device] : summary.sensors) {
    if (id.kind != SensorKind::kLidar) continue;
    Level& level = totals.levels.lidars.at(id.index);
    level = worst_level(level, find_problems(device, totals.counters.lidars.at(id.index)));
  }
  return summary;
}

/// Runs the drive through the pipeline without clients.
Summary replay(SensorSetup setup) {
  boost::asio::io_context io(1);
  Server server(io, {}, "", "");
  Replay replay(io, std::move(setup), {}, server, nullptr,
                [&] { server.finish(std::chrono::milliseconds(0)); });
  replay.start();
  io.run();
  return summarise(replay);
}

const char* name_of(lidar::PacketClass packet_class) {
  switch (packet_class) {
    case lidar::PacketClass::kData:
      return "lidar packets";
    case lidar::PacketClass::kInformation:
      return "position packets";
    case lidar::PacketClass::kInertial:
      return "inertial packets";
    case lidar::PacketClass::kOther:
      return "other datagrams";
  }
  return "";
}

Json arrivals_json(const std::string& what, const makers::Arrivals& arrivals) {
  return {{"what", what},
          {"count", arrivals.count},
          {"rate_hz", rounded(arrivals.rate_hz())},
          {"first", arrivals.first.ns()},
          {"last", arrivals.last.ns()},
          {"longest_gap_s", to_seconds(arrivals.longest_gap)}};
}

std::string arrivals_text(const std::string& what, const makers::Arrivals& arrivals) {
  return fmt::format("  {} {}: {:.1f}/s over {:.3f} s, longest gap {:.1f} ms\n", arrivals.count,
                     what, arrivals.rate_hz(), to_seconds(arrivals.span()),
                     to_seconds(arrivals.longest_gap) * 1e3);
}

}  // namespace

Result<Inspection> inspect_recording(const std::filesystem::path& path,
                                     const LidarOverrides& overrides, ProgressLine& line) {
  std::error_code ignored;
  const bool drive = std::filesystem::is_directory(path, ignored);
  line.show(std::nullopt, "reading " + path.string());
  auto contents = drive ? survey_drive(path) : survey_capture(path);
  if (!contents) return tl::unexpected(contents.error());
  line.show(std::nullopt, "decoding " + path.string());
  return Inspection{path, *std::move(contents),
                    open_drive(path, {}, overrides).map(replay).map(judge_lidars)};
}

bool has_lidar(const Inspection& inspection) {
  const Result<Summary>& summary = inspection.summary;
  if (!summary) return false;
  const auto& counters = summary->totals.counters.lidars;
  return std::any_of(counters.begin(), counters.end(),
                     [](const LidarCounters& c) { return c.packets > 0; });
}

std::vector<std::string> list_problems(const Inspection& inspection) {
  const auto& [path, contents, summary] = inspection;
  std::vector<std::string> list;
  // The replay read the same files, and parsed their lines too.
  const std::vector<Error>& notes = summary ? summary->notes : contents.notes;
  for (const Error& note : notes) list.push_back(note.message());
  for (const makers::Stream& stream : contents.survey.streams()) {
    if (stream.arrivals.backward > 0) {
      list.push_back(fmt::format("{} datagrams to port {} have stamps before the previous one",
                                 stream.arrivals.backward, stream.port));
    }
  }
  if (!summary) {
    list.push_back(summary.error().message());
    return list;
  }
  for (const AlertReport& alert : summary->totals.first_alerts) {
    list.push_back(fmt::format("{:.0f} s into the drive: {}: {} ({})",
                               to_seconds(alert.stamp - summary->totals.start), alert.device,
                               alert.finding.what, alert.finding.advice));
  }
  for (const LidarProblem& problem : find_problems(*summary)) list.push_back(problem.what);
  return list;
}

Json to_json(const Inspection& inspection) {
  const auto& [path, contents, summary] = inspection;
  Json json = {{"path", path.string()}, {"streams", Json::array()}};
  for (const makers::Stream& stream : contents.survey.streams()) {
    Json entry = arrivals_json(name_of(stream.packet_class), stream.arrivals);
    entry["sender"] = address_text(stream.sender);
    entry["port"] = stream.port;
    entry["last_size_bytes"] = stream.last_size;
    if (stream.maker != nullptr) entry["maker"] = stream.maker->name();
    if (!stream.statement.empty()) entry["states"] = stream.statement;
    json["streams"].push_back(std::move(entry));
  }
  for (const auto& [what, arrivals] : contents.other_streams) {
    json["streams"].push_back(arrivals_json(what, arrivals));
  }
  const std::string unread = contents.survey.describe_unread();
  if (!unread.empty()) json["not_read"] = unread;
  json["devices"] = Json::array();
  if (summary) {
    const Json replayed = to_json(*summary);
    json["devices"] = replayed["devices"];
    json["sensors"] = replayed["streams"];
    if (replayed.contains("odometry")) json["odometry"] = replayed["odometry"];
    json["uses"] = Json::array();
    for (const DriveUse& use : drive_uses(*summary, contents.has_map)) {
      const std::string condition = use.if_standing ? answer(use) + std::string("; ") : "";
      json["uses"].push_back(
          {{"use", use.use}, {"possible", use.possible}, {"statement", condition + use.statement}});
    }
  }
  json["problems"] = list_problems(inspection);
  return json;
}

std::string to_text(const Inspection& inspection) {
  const auto& [path, contents, summary] = inspection;
  std::string text = path.string() + "\nstreams\n";
  for (const makers::Stream& stream : contents.survey.streams()) {
    text += arrivals_text(
        fmt::format("{} from {} to port {}{}", name_of(stream.packet_class),
                    address_text(stream.sender), stream.port,
                    stream.maker != nullptr ? fmt::format(" ({})", stream.maker->name()) : ""),
        stream.arrivals);
    if (!stream.statement.empty()) text += "    " + stream.statement + "\n";
  }
  for (const auto& [what, arrivals] : contents.other_streams) text += arrivals_text(what, arrivals);
  const std::string unread = contents.survey.describe_unread();
  if (!unread.empty()) text += "  not read: " + unread + "\n";
  if (summary) {
    text += "lidars\n";
    std::string others;
    for (const Sensor& sensor : summary->sensors) {
      (sensor.id.kind == SensorKind::kLidar ? text : others) +=
          sensor_text(sensor, summary->totals);
    }
    if (!others.empty()) text += "cameras and the vehicle\n" + others;
    if (summary->has_odometry) text += odometry_text(summary->totals.odometry);
    text += "can be used for\n";
    for (const DriveUse& use : drive_uses(*summary, contents.has_map)) {
      text += fmt::format("  {}: {}; {}\n", use.use, answer(use), use.statement);
    }
  }
  const auto list = list_problems(inspection);
  text += list.empty() ? "no problems\n" : "problems\n";
  for (const std::string& problem : list) text += "  " + problem + "\n";
  return text;
}

}  // namespace infuse::daemon
