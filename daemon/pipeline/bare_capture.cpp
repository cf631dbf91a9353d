#include "daemon/pipeline/bare_capture.hpp"

#include <spdlog/fmt/fmt.h>

#include "drivers/recording/pcap_reader.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxSurveyDatagrams = 20'000;
constexpr uint64_t kMinPackets = 10;  // a stream of fewer is noise beside another one

recording::LidarFiles files_of(const std::filesystem::path& path, const LidarOptions& options) {
  recording::LidarFiles files;
  files.packets = path.filename();
  files.port = options.port;
  files.sender = parse_address(options.sender);
  files.calibration = options.calibration;
  return files;
}

recording::LidarFiles files_of(const std::filesystem::path& path, const Stream& stream) {
  recording::LidarFiles files;
  files.packets = path.filename();
  files.port = stream.port;
  files.sender = stream.sender;
  return files;
}

void add_lidar(recording::DriveDescription& description, const std::string& name,
               const std::string& model, recording::LidarFiles files) {
  // Two sensors behind one address cannot share its position packets; the first has them.
  for (const recording::LidarFiles& other : description.lidars) {
    if (other.sender == files.sender && other.position_port == files.position_port) {
      files.position_port = files.port ^ 0x8000;
    }
  }
  LidarMount mount;
  mount.name = name;
  mount.model = model;
  description.rig.lidars.push_back(mount);
  description.lidars.push_back(std::move(files));
}

std::string describe_contents(const CaptureSurvey& survey) {
  if (survey.streams().empty()) return "it holds no UDP datagrams";
  const Stream& stream = survey.streams().front();
  return fmt::format("it holds e.g. {} datagrams of {} bytes from {} to port {}",
                     stream.arrivals.count, stream.last_size, address_text(stream.sender),
                     stream.port);
}

}  // namespace

Result<CaptureSurvey> survey_beginning(const std::filesystem::path& path) {
  auto reader = recording::PcapReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  CaptureSurvey survey;
  Datagram datagram;
  for (size_t i = 0; i < kMaxSurveyDatagrams && reader->next(datagram); ++i) survey.add(datagram);
  return survey;
}

Result<recording::Drive> describe_capture(const std::filesystem::path& path,
                                          const CaptureSurvey& survey,
                                          const std::vector<LidarOptions>& lidars) {
  recording::Drive drive;
  drive.folder = path.parent_path();
  recording::DriveDescription& description = drive.description;
  for (const LidarOptions& options : lidars) {
    add_lidar(description, options.name, options.model, files_of(path, options));
  }
  size_t data_streams = 0;
  for (const Stream& stream : survey.streams()) data_streams += stream.kind == StreamKind::kData;
  for (const Stream& stream : survey.streams()) {
    const bool noise = data_streams > 1 && stream.arrivals.count < kMinPackets;
    if (!lidars.empty() || stream.kind != StreamKind::kData || noise) continue;
    const size_t number = description.lidars.size() + 1;
    add_lidar(description, number == 1 ? "lidar" : fmt::format("lidar{}", number), "",
              files_of(path, stream));
  }
  if (description.lidars.empty()) {
    return fail("no lidar packets are in this capture", path.string(), describe_contents(survey));
  }
  if (const auto wrong = description.invalid()) return fail(*wrong, path.string());
  return drive;
}

std::optional<velodyne::InferredModel> infer_model(const CaptureSurvey& survey,
                                                   const recording::LidarFiles& files) {
  for (const Stream& stream : survey.streams()) {
    const bool its_sender = !files.sender || *files.sender == stream.sender;
    if (stream.kind == StreamKind::kData && stream.port == files.port && its_sender) {
      return stream.inference.infer();
    }
  }
  return std::nullopt;
}

}  // namespace infuse::daemon
