#include "drivers/hesai/hesai_maker.hpp"

#include <memory>
#include <string>
#include <vector>

#include "drivers/gnss/nmea.hpp"
#include "drivers/hesai/calibration_file.hpp"
#include "drivers/hesai/decoder.hpp"
#include "drivers/hesai/example_turn.hpp"
#include "drivers/hesai/firing_times.hpp"
#include "drivers/hesai/gps_packet.hpp"
#include "drivers/hesai/packet.hpp"
#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/lidar/little_endian.hpp"

namespace infuse::hesai {
namespace {

std::vector<lidar::LidarModel> lidar_models() {
  std::vector<lidar::LidarModel> list;
  for (const ModelInfo& info : models()) {
    list.push_back({.name = info.name, .beams = info.lasers, .has_dual_return = true});
  }
  return list;
}

class Maker final : public lidar::LidarMaker {
 public:
  Maker() : LidarMaker("Hesai", {.data = 2368, .information = 10110}, lidar_models()) {}

  lidar::PacketClass classify(std::span<const uint8_t> payload) const override {
    if (looks_like_hesai(payload)) return lidar::PacketClass::kData;
    if (is_gps_packet(payload)) return lidar::PacketClass::kInformation;
    return lidar::PacketClass::kOther;
  }

  std::optional<lidar::StatedPacket> read_stated(std::span<const uint8_t> payload) const override {
    const auto model = recognise(payload);
    if (!model) {
      return looks_like_hesai(payload) ? std::optional(lidar::StatedPacket()) : std::nullopt;
    }
    const auto packet = parse_packet(model_info(*model), payload);
    if (!packet) return std::nullopt;
    return lidar::StatedPacket{&lidar_model(*model), Duration(packet->utc_ns), packet->azimuth[0]};
  }

  std::string describe(std::span<const uint8_t> payload) const override {
    const auto model = recognise(payload);
    if (!model) return "";
    const ModelInfo& info = model_info(*model);
    const auto packet = parse_layout(info, payload);
    if (!packet) return "";
    std::string text;
    if (info.protocol != 0) {
      text = "protocol " + std::to_string(payload[2]) + "." + std::to_string(payload[3]) + ", ";
    }
    return text + name_of(packet->mode) + (packet->returns > 1 ? " returns" : " return");
  }

  Result<std::unique_ptr<lidar::LidarDecoder>> new_decoder(
      const lidar::DecoderOptions& options) const override {
    return std::make_unique<Decoder>(options);
  }

  Result<std::shared_ptr<const lidar::UnitCalibration>> load_calibration(
      const lidar::LidarModel& model, const std::filesystem::path& file) const override {
    const Model of_unit = model_of(model);
    const auto loaded = load_angle_csv(file, model_info(of_unit));
    if (!loaded) return tl::unexpected(loaded.error());
    return std::make_shared<UnitCalibration>(of_unit, *loaded);
  }

  std::vector<uint8_t> example_packet(const lidar::LidarModel& model, uint32_t index,
                                      double radius) const override {
    const ModelInfo& info = model_info(model_of(model));
    const bool is_xt = info.model == Model::kXt16 || info.model == Model::kXt32;
    return is_xt ? hesai::example_packet(info, index, radius) : std::vector<uint8_t>();
  }

  Duration example_period(const lidar::LidarModel& model) const override {
    return model_info(model_of(model)).period * model_info(model_of(model)).blocks;
  }

  lidar::RosPackets ros_packets() const override { return lidar::RosPackets::kPandarScan; }

  std::optional<GnssFix> read_fix(const Datagram& datagram) const override {
    const auto packet = parse_gps_packet(datagram.payload);
    if (!packet || !packet->sentence) return std::nullopt;
    return gnss::stamped_fix(*packet->sentence, datagram.stamp);
  }

  uint16_t first_azimuth(std::span<const uint8_t> payload) const override {
    const auto model = recognise(payload);
    if (!model) return 0;
    const ModelInfo& info = model_info(*model);
    return lidar::read_u16(payload.data() + info.header_size + info.block_prefix - 2);
  }
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
  return static_cast<Model>(maker().index_of(model));
}

}  // namespace infuse::hesai
