#include "drivers/ouster/ouster_maker.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/ouster/decoder.hpp"
#include "drivers/ouster/imu_packet.hpp"
#include "drivers/ouster/metadata_request.hpp"
#include "drivers/ouster/packet_inference.hpp"

namespace infuse::ouster {
namespace {

constexpr std::string_view kUrl = "http://";
constexpr std::chrono::milliseconds kRequestTimeout{5000};
constexpr size_t kMaxMetadataFiles = 16;

struct ModelName {
  const char* name;
  uint16_t beams;
};
constexpr std::array<ModelName, 15> kModels{{{"OS0-32", 32},
                                             {"OS0-64", 64},
                                             {"OS0-128", 128},
                                             {"OS1-16", 16},
                                             {"OS1-32", 32},
                                             {"OS1-64", 64},
                                             {"OS1-128", 128},
                                             {"OS2-32", 32},
                                             {"OS2-64", 64},
                                             {"OS2-128", 128},
                                             {"OSDome-32", 32},
                                             {"OSDome-64", 64},
                                             {"OSDome-128", 128},
                                             {"OS0-16", 16},
                                             {"OS2-16", 16}}};

/// Metadata from a file, or from the sensor itself: "http://ADDRESS".
Result<Metadata> read_metadata(const std::filesystem::path& source) {
  const std::string name = source.string();
  if (!name.starts_with(kUrl)) return load_metadata(source);
  const std::string host = name.substr(kUrl.size(), name.find('/', kUrl.size()) - kUrl.size());
  const auto text = request_metadata(host, kRequestTimeout);
  if (!text) return tl::unexpected(text.error());
  return parse_metadata(*text, name);
}

/// Name of a capture without .pcap.zst and the like.
std::string stem_of(const std::filesystem::path& capture) {
  const std::string name = capture.filename().string();
  const size_t end = name.rfind(".pcap");
  return end == std::string::npos ? capture.stem().string() : name.substr(0, end);
}

/// True for NAME.json, NAME.2.json and NAME_0.json, as recorders write them beside NAME.pcap.
bool belongs_to(const std::string& stem, const std::string& name) {
  if (!name.starts_with(stem) || !name.ends_with(".json")) return false;
  const std::string_view middle =
      std::string_view(name).substr(stem.size(), name.size() - stem.size() - 5);
  if (middle.empty() || middle[0] == '.') return true;
  return middle[0] == '_' && middle.find_first_not_of("0123456789", 1) == std::string::npos;
}

/// Files beside a capture, or in a folder of captures, in which its sensors' metadata may be.
std::vector<std::filesystem::path> metadata_files(const std::filesystem::path& capture) {
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(capture, error);
  const std::string stem = stem_of(capture);
  const auto folder = is_folder || !capture.has_parent_path()
                          ? (is_folder ? capture : std::filesystem::path("."))
                          : capture.parent_path();
  std::vector<std::filesystem::path> files;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (is_folder ? name.ends_with(".json") : belongs_to(stem, name)) {
      files.push_back(entry->path());
    }
  }
  std::ranges::sort(
      files, {}, [](const auto& file) { return std::pair(file.filename().string().size(), file); });
  if (files.size() > kMaxMetadataFiles) files.resize(kMaxMetadataFiles);
  return files;
}

std::vector<lidar::LidarModel> lidar_models() {
  std::vector<lidar::LidarModel> list;
  for (const ModelName& model : kModels) {
    list.push_back({.name = model.name,
                    .beams = model.beams,
                    .calibrated_per_unit = true,
                    .has_dual_return = true});
  }
  return list;
}

/// "firmware v2.3.0, serial number 992110000123, RNG19_RFL8_SIG16_NIR16, 1024 columns, time of
/// PTP".
std::string describe_unit(const Metadata& metadata) {
  std::string text;
  if (!metadata.firmware.empty()) text += "firmware " + metadata.firmware + ", ";
  if (!metadata.serial_number.empty()) text += "serial number " + metadata.serial_number + ", ";
  text.append(profile_info(metadata.profile).name);
  text += ", " + std::to_string(metadata.columns_per_turn) + " columns";
  if (metadata.has_other_imu) text += ", inertial packets of a profile that is not read";
  if (metadata.time_mode == TimeMode::kUnknown) return text;
  return text + ", time of " + describe(metadata.time_mode);
}

class Maker final : public lidar::LidarMaker {
 public:
  Maker() : LidarMaker("Ouster", {.data = 7502, .information = 7503}, lidar_models()) {}

  lidar::PacketClass classify(std::span<const uint8_t> payload) const override {
    if (is_imu_packet(payload)) return lidar::PacketClass::kInertial;
    return read_head(payload) ? lidar::PacketClass::kData : lidar::PacketClass::kOther;
  }

  std::unique_ptr<lidar::ModelInference> make_inference() const override {
    return std::make_unique<PacketInference>();
  }

  Result<std::unique_ptr<lidar::LidarDecoder>> new_decoder(
      const lidar::DecoderOptions& options) const override {
    if (options.calibration == nullptr) return missing_metadata(options.model->name);
    return std::make_unique<Decoder>(options);
  }

  Result<std::shared_ptr<const lidar::UnitCalibration>> load_calibration(
      const lidar::LidarModel& model, const std::filesystem::path& file) const override {
    const auto metadata = read_metadata(file);
    if (!metadata) return tl::unexpected(metadata.error());
    const lidar::LidarModel* stated = model_of(*metadata);
    if (stated != &model) {
      return fail("is the metadata of a sensor " + metadata->model() + ", not " + model.name,
                  file.string(), "check that the file belongs to this sensor");
    }
    return std::make_shared<UnitCalibration>(*metadata);
  }

  Result<std::optional<lidar::StatedModel>> find_calibration(
      const std::filesystem::path& capture, const std::filesystem::path& stated,
      const lidar::ModelInference& packets) const override {
    if (!stated.empty()) return read_model(stated);
    const auto& shown = dynamic_cast<const PacketInference&>(packets);
    std::string reason;  // why the files that are there do not do
    for (const std::filesystem::path& file : metadata_files(capture)) {
      const auto metadata = load_metadata(file);
      if (metadata && shown.fits(*metadata)) return read_model(file);
      if (!metadata && reason.empty()) reason = metadata.error().message();
      if (metadata) reason = file.string() + " is of another sensor";
    }
    return missing_metadata(capture.string(), reason);
  }

  lidar::RosPackets ros_packets() const override { return lidar::RosPackets::kOusterPacket; }

  size_t max_datagram() const override { return 33'024; }

 private:
  static tl::unexpected<Error> missing_metadata(const std::string& where,
                                                const std::string& reason = "") {
    return fail("the sensor's metadata is missing" + (reason.empty() ? "" : ": " + reason), where,
                "store what it gives at http://ADDRESS/api/v1/sensor/metadata as NAME.json beside "
                "NAME.pcap, or name the file or http://ADDRESS by calibration");
  }

  Result<std::optional<lidar::StatedModel>> read_model(const std::filesystem::path& file) const {
    const auto metadata = read_metadata(file);
    if (!metadata) return tl::unexpected(metadata.error());
    const lidar::LidarModel* model = model_of(*metadata);
    if (model == nullptr) {
      return fail("states the unknown model \"" + metadata->model() + "\"", file.string());
    }
    return lidar::StatedModel{model, file, describe_unit(*metadata)};
  }
};

}  // namespace

const lidar::LidarMaker& maker() {
  static const Maker maker;
  return maker;
}

const lidar::LidarModel* model_of(const Metadata& metadata) {
  const lidar::LidarMaker* const list[] = {&maker()};
  return lidar::find_model(list, metadata.model());
}

}  // namespace infuse::ouster
