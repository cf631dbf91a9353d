#include "drivers/lidar/lidar_maker.hpp"

#include <cctype>
#include <utility>

#include "drivers/lidar/stated_model_inference.hpp"

namespace infuse::lidar {
namespace {

bool is_same_name(std::string_view a, std::string_view b) {
  const auto is_alphanumeric = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0;
  };
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  size_t i = 0;
  size_t j = 0;
  while (true) {
    while (i < a.size() && !is_alphanumeric(a[i])) ++i;
    while (j < b.size() && !is_alphanumeric(b[j])) ++j;
    if (i == a.size() || j == b.size()) return i == a.size() && j == b.size();
    if (lower(a[i++]) != lower(b[j++])) return false;
  }
}

}  // namespace

LidarMaker::LidarMaker(const char* name, LidarPorts ports, std::vector<LidarModel> models)
    : name_(name), ports_(ports), models_(std::move(models)) {
  for (LidarModel& model : models_) model.maker = this;
}

std::optional<StatedPacket> LidarMaker::read_stated(std::span<const uint8_t>) const {
  return std::nullopt;
}

std::string LidarMaker::describe(std::span<const uint8_t>) const { return ""; }

std::unique_ptr<ModelInference> LidarMaker::make_inference() const {
  return std::make_unique<StatedModelInference>(*this);
}

Result<std::shared_ptr<const UnitCalibration>> LidarMaker::load_calibration(
    const LidarModel& model, const std::filesystem::path& file) const {
  return fail("a " + std::string(model.name) + " has no calibration file", file.string());
}

std::optional<GnssFix> LidarMaker::read_fix(const Datagram&) const { return std::nullopt; }

Result<std::optional<StatedModel>> LidarMaker::find_calibration(const std::filesystem::path&,
                                                                const std::filesystem::path&,
                                                                const ModelInference&) const {
  return std::nullopt;
}

uint16_t LidarMaker::first_azimuth(std::span<const uint8_t> payload) const {
  const auto packet = read_stated(payload);
  return packet ? static_cast<uint16_t>(packet->azimuth) : uint16_t{0};
}

std::optional<FoundPacket> LidarMaker::find_packet(std::span<const uint8_t>) const {
  return std::nullopt;
}

std::vector<uint8_t> LidarMaker::example_packet(const LidarModel&, uint32_t, double) const {
  return {};
}

Duration LidarMaker::example_period(const LidarModel&) const { return Duration(0); }

const LidarModel* find_model(MakerList makers, std::string_view name) {
  for (const LidarMaker* maker : makers) {
    for (const LidarModel& model : maker->models()) {
      if (is_same_name(model.name, name)) return &model;
    }
  }
  return nullptr;
}

ClassifiedPacket classify(MakerList makers, std::span<const uint8_t> payload) {
  for (const LidarMaker* maker : makers) {
    const PacketClass packet_class = maker->classify(payload);
    if (packet_class != PacketClass::kOther) return {maker, packet_class};
  }
  return {};
}

Result<std::unique_ptr<LidarDecoder>> make_decoder(const DecoderOptions& options) {
  if (const auto wrong = options.invalid()) return fail(*wrong, options.model->name);
  if (options.calibration != nullptr && options.calibration->model != options.model) {
    return fail("the calibration is another model's", options.model->name);
  }
  return options.model->maker->new_decoder(options);
}

}  // namespace infuse::lidar
