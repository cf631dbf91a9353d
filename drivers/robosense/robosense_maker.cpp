#include "drivers/robosense/robosense_maker.hpp"

#include <array>

#include "drivers/gnss/nmea.hpp"
#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/lidar/stated_model_inference.hpp"
#include "drivers/robosense/decoder.hpp"
#include "drivers/robosense/info_packet.hpp"

namespace infuse::robosense {
namespace {

std::optional<lidar::StatedModelInference::Packet> read_stated_model(
    std::span<const uint8_t> payload) {
  const auto packet = parse_packet(payload);
  if (!packet) return std::nullopt;
  const auto model = stated_model(payload);
  return lidar::StatedModelInference::Packet{model ? &lidar_model(*model) : nullptr,
                                             Duration(packet->time_ns), packet->azimuth[0]};
}

class Maker final : public lidar::LidarMaker {
 public:
  Maker() {
    for (const ModelInfo& info : robosense::models()) {
      models_[static_cast<size_t>(info.model)] = {.maker = this,
                                                  .name = info.name,
                                                  .beams = info.lasers,
                                                  .calibrated_per_unit = true,
                                                  .has_dual_return = true};
    }
  }

  const char* name() const override { return "RoboSense"; }
  std::span<const lidar::LidarModel> models() const override { return models_; }

  lidar::PacketClass classify(std::span<const uint8_t> payload) const override {
    if (is_data_packet(payload)) return lidar::PacketClass::kData;
    if (is_info_packet(payload)) return lidar::PacketClass::kInformation;
    return lidar::PacketClass::kOther;
  }

  std::unique_ptr<lidar::ModelInference> make_inference() const override {
    return std::make_unique<lidar::StatedModelInference>(read_stated_model, Duration(0));
  }

  Result<std::unique_ptr<lidar::LidarDecoder>> make_decoder(
      const lidar::DecoderOptions& options) const override {
    if (const auto wrong = options.invalid()) return fail(*wrong, options.model->name);
    if (options.calibration != nullptr) {
      const auto* unit = dynamic_cast<const UnitCalibration*>(options.calibration.get());
      if (unit == nullptr || unit->model != model_of(*options.model)) {
        return fail("the calibration is another model's", options.model->name);
      }
    }
    return std::make_unique<Decoder>(options);
  }

  lidar::LidarPorts ports() const override { return {.data = 6699, .information = 7788}; }

  std::optional<GnssFix> read_fix(const Datagram& datagram) const override {
    const auto packet = parse_info_packet(datagram.payload);
    if (!packet || !packet->sentence) return std::nullopt;
    return gnss::stamped_fix(*packet->sentence, datagram.stamp);
  }

  uint16_t first_azimuth(std::span<const uint8_t> payload) const override {
    const auto packet = parse_packet(payload);
    return packet ? packet->azimuth[0] : uint16_t{0};
  }

  std::optional<lidar::FoundPacket> find_packet(std::span<const uint8_t> bytes) const override {
    if (bytes.size() < kPacketSize) return std::nullopt;
    const lidar::PacketClass found = classify(bytes.first(kPacketSize));
    if (found == lidar::PacketClass::kOther) return std::nullopt;
    return lidar::FoundPacket{found, kPacketSize, true};
  }

 private:
  std::array<lidar::LidarModel, 2> models_;
};

}  // namespace

const lidar::LidarMaker& maker() {
  static const Maker maker;
  return maker;
}

const lidar::LidarModel& lidar_model(Model model) {
  return maker().models()[static_cast<size_t>(model)];
}

Model model_of(const lidar::LidarModel& model) {
  return static_cast<Model>(&model - maker().models().data());
}

}  // namespace infuse::robosense
