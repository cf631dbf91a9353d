#include "drivers/robosense/robosense_maker.hpp"

#include <memory>
#include <string>
#include <vector>

#include "drivers/gnss/nmea.hpp"
#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/robosense/decoder.hpp"
#include "drivers/robosense/example_turn.hpp"
#include "drivers/robosense/info_packet.hpp"

namespace infuse::robosense {
namespace {

std::vector<lidar::LidarModel> lidar_models() {
  std::vector<lidar::LidarModel> list;
  for (const ModelInfo& info : models()) {
    list.push_back({.name = info.name,
                    .beams = info.lasers,
                    .calibrated_per_unit = true,
                    .has_dual_return = true});
  }
  return list;
}

class Maker final : public lidar::LidarMaker {
 public:
  Maker() : LidarMaker("RoboSense", {.data = 6699, .information = 7788}, lidar_models()) {}

  lidar::PacketClass classify(std::span<const uint8_t> payload) const override {
    if (is_data_packet(payload) || is_foreign_data_packet(payload)) {
      return lidar::PacketClass::kData;
    }
    if (is_info_packet(payload)) return lidar::PacketClass::kInformation;
    return lidar::PacketClass::kOther;
  }

  std::optional<lidar::StatedPacket> read_stated(std::span<const uint8_t> payload) const override {
    if (is_foreign_data_packet(payload)) return lidar::StatedPacket();
    const auto packet = parse_packet(payload);
    if (!packet) return std::nullopt;
    const auto model = stated_model(payload);
    return lidar::StatedPacket{model ? &lidar_model(*model) : nullptr, Duration(packet->time_ns),
                               packet->azimuth[0]};
  }

  std::string describe(std::span<const uint8_t> payload) const override {
    const auto packet = parse_info_packet(payload);
    if (!packet) return "";
    std::string text;
    const auto add = [&](const std::string& more) { text += (text.empty() ? "" : ", ") + more; };
    if (!packet->software.empty()) add("software " + packet->software);
    if (!packet->serial_number.empty()) add("serial number " + packet->serial_number);
    if (packet->mode) add(name_of(*packet->mode));
    if (packet->time_mode) add(std::string("time of ") + name_of(*packet->time_mode));
    if (packet->time_mode && !packet->synchronised) add("which is not there");
    return text;
  }

  Result<std::unique_ptr<lidar::LidarDecoder>> new_decoder(
      const lidar::DecoderOptions& options) const override {
    return std::make_unique<Decoder>(options);
  }

  std::vector<uint8_t> example_packet(const lidar::LidarModel& model, uint32_t index,
                                      double radius) const override {
    if (model_of(model) != Model::kHelios) return {};
    return robosense::example_packet(index, radius);
  }

  Duration example_period(const lidar::LidarModel&) const override {
    return Duration(int64_t{kHeliosPeriodNs} * static_cast<int64_t>(kBlocks));
  }

  lidar::RosPackets ros_packets() const override { return lidar::RosPackets::kRslidarPacket; }

  std::optional<GnssFix> read_fix(const Datagram& datagram) const override {
    const auto packet = parse_info_packet(datagram.payload);
    if (!packet || !packet->sentence) return std::nullopt;
    return gnss::stamped_fix(*packet->sentence, datagram.stamp);
  }

  std::optional<lidar::FoundPacket> find_packet(std::span<const uint8_t> bytes) const override {
    if (bytes.size() < kPacketSize) return std::nullopt;
    const lidar::PacketClass found = classify(bytes.first(kPacketSize));
    if (found == lidar::PacketClass::kOther) return std::nullopt;
    return lidar::FoundPacket{found, kPacketSize, true};
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

}  // namespace infuse::robosense
