#include "daemon/setup/bare_capture.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "drivers/makers/makers.hpp"
#include "drivers/recording/capture_reader.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxSurveyDatagrams = 20'000;
constexpr uint16_t kUnusedPortBit = 0x8000;
constexpr uint64_t kMinPackets =
    10;  // a stream of fewer packets is noise if there is another stream

/// The path of a capture or of a folder of captures, with the name at its end.
std::filesystem::path named_path(const std::filesystem::path& path) {
  const bool above = path.lexically_normal().filename() == "..";
  const auto plain = (above ? std::filesystem::absolute(path) : path).lexically_normal();
  return plain.has_filename() ? plain : plain.parent_path();
}

recording::LidarFiles files_of(const std::filesystem::path& path, const LidarOptions& options) {
  recording::LidarFiles files;
  files.packets = path.filename();
  files.port = options.port;
  files.sender = parse_address(options.sender);
  files.calibration = options.calibration;
  return files;
}

recording::LidarFiles files_of(const std::filesystem::path& path, const makers::Stream& stream) {
  recording::LidarFiles files;
  files.packets = path.filename();
  files.port = stream.port;
  const uint16_t information = stream.maker->ports().information;
  files.position_port = information != stream.port ? information : stream.port ^ kUnusedPortBit;
  files.sender = stream.sender;
  return files;
}

void add_lidar(recording::DriveDescription& description, const std::string& name,
               const std::string& model, recording::LidarFiles files) {
  // Two sensors behind one address cannot share its position packets; the first one gets them,
  // the others get a port that nothing is sent to.
  for (const recording::LidarFiles& other : description.lidars) {
    if (other.sender == files.sender && other.position_port == files.position_port) {
      files.position_port = files.port ^ kUnusedPortBit;
    }
  }
  LidarMount mount;
  mount.name = name;
  mount.model = model;
  description.rig.lidars.push_back(mount);
  description.lidars.push_back(std::move(files));
}

/// True if a stream comes from the lidar's address to this port.
bool is_from(const recording::LidarFiles& files, const makers::Stream& stream, uint16_t port) {
  return stream.port == port && (!files.sender || *files.sender == stream.sender);
}

/// True if the lidar's information packets carry fixes of a GNSS receiver.
bool has_fixes(const makers::CaptureSurvey& survey, const recording::LidarFiles& files) {
  return std::any_of(
      survey.streams().begin(), survey.streams().end(), [&](const makers::Stream& stream) {
        return stream.fixes > 0 &&
               (is_from(files, stream, files.position_port) || is_from(files, stream, files.port));
      });
}

/// Whose data come to this port as lidars leave the factory, if one maker's do: for packets that
/// are of no known maker.
std::string describe_port(uint16_t port) {
  const lidar::LidarMaker* found = nullptr;
  for (const lidar::LidarMaker* maker : makers::all()) {
    if (maker->ports().data != port) continue;
    if (found != nullptr) return "";
    found = maker;
  }
  if (found == nullptr) return "";
  return fmt::format(", which {}'s lidars use, but in no layout of packets that is known",
                     found->name());
}

std::string describe_contents(const makers::CaptureSurvey& survey) {
  if (survey.streams().empty()) {
    const std::string unread = survey.describe_unread();
    return "it holds no complete UDP datagrams" + (unread.empty() ? "" : ", but " + unread);
  }
  const makers::Stream& stream = survey.streams().front();
  return fmt::format("it holds e.g. {} datagrams of {} bytes from {} to port {}{}",
                     stream.arrivals.count, stream.last_size, address_text(stream.sender),
                     stream.port, describe_port(stream.port));
}

}  // namespace

Result<makers::CaptureSurvey> survey_beginning(const std::filesystem::path& path) {
  auto reader = recording::CaptureReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  makers::CaptureSurvey survey;
  Datagram datagram;
  for (size_t i = 0; i < kMaxSurveyDatagrams && reader->next(datagram); ++i) survey.add(datagram);
  survey.set_packets(reader->counters());
  return survey;
}

Result<recording::Drive> describe_capture(const std::filesystem::path& capture,
                                          const makers::CaptureSurvey& survey,
                                          const std::vector<LidarOptions>& lidars) {
  const std::filesystem::path path = named_path(capture);
  recording::Drive drive;
  drive.folder = path.parent_path();
  recording::DriveDescription& description = drive.description;
  for (const LidarOptions& options : lidars) {
    add_lidar(description, options.name, options.model, files_of(path, options));
  }
  uint64_t max_packets = 0;
  for (const makers::Stream& stream : survey.streams()) {
    if (stream.has_data()) max_packets = std::max(max_packets, stream.arrivals.count);
  }
  for (const makers::Stream& stream : survey.streams()) {
    const bool noise = max_packets >= kMinPackets && stream.arrivals.count < kMinPackets;
    if (!lidars.empty() || !stream.has_data() || noise) continue;
    const size_t number = description.lidars.size() + 1;
    add_lidar(description, number == 1 ? "lidar" : fmt::format("lidar{}", number), "",
              files_of(path, stream));
  }
  if (description.lidars.empty()) {
    return fail("no lidar packets in this capture", path.string(), describe_contents(survey));
  }
  for (size_t i = 0; i < description.lidars.size() && description.gnss_lidar.empty(); ++i) {
    if (!has_fixes(survey, description.lidars[i])) continue;
    description.gnss_lidar = description.rig.lidars[i].name;
  }
  if (const auto wrong = description.invalid()) return fail(*wrong, path.string());
  return drive;
}

const makers::Stream* find_data_stream(const makers::CaptureSurvey& survey,
                                       const recording::LidarFiles& files) {
  const makers::Stream* found = nullptr;
  for (const makers::Stream& stream : survey.streams()) {
    if (!stream.has_data() || !is_from(files, stream, files.port)) continue;
    if (found == nullptr || stream.arrivals.count > found->arrivals.count) found = &stream;
  }
  return found;
}

std::shared_ptr<const lidar::UnitCalibration> find_streamed_calibration(
    const std::filesystem::path& path, const recording::LidarFiles& files,
    const lidar::DecoderOptions& options) {
  auto reader = recording::CaptureReader::open(path, {.ports = {files.port, files.position_port}});
  if (!reader) return nullptr;
  const auto decoder = lidar::make_decoder(options).value();
  Sweep sweep;
  Datagram datagram;
  for (size_t i = 0; i < kMaxSurveyDatagrams && reader->next(datagram); ++i) {
    decoder->push(datagram);
    while (decoder->pull(sweep)) sweep.clear();
    if (auto calibration = decoder->streamed_calibration()) return calibration;
  }
  return nullptr;
}

}  // namespace infuse::daemon
