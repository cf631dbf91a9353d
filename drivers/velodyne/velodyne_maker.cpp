#include "drivers/velodyne/velodyne_maker.hpp"

#include <memory>
#include <vector>

#include "drivers/gnss/nmea.hpp"
#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/velodyne/calibration_file.hpp"
#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/example_turn.hpp"
#include "drivers/velodyne/model_inference.hpp"
#include "drivers/velodyne/packet.hpp"
#include "drivers/velodyne/position_packet.hpp"

namespace infuse::velodyne {
namespace {

constexpr size_t kSentencePlace = 0xCE;  // of a position packet

/// Number of blocks that begin with a flag of any model.
size_t count_flags(std::span<const uint8_t> payload) {
  size_t flags = 0;
  for (size_t block = 0; block < kBlocks; ++block) {
    const uint8_t* bytes = block_at(payload, block);
    const uint8_t bank = bytes[1];
    flags += bytes[0] == 0xFF && (bank == 0xEE || bank == 0xDD || bank == 0xCC || bank == 0xBB);
  }
  return flags;
}

/// True if bytes are a data packet of any model: all flags, most azimuths.
bool is_data_packet(std::span<const uint8_t> payload) {
  size_t azimuths = 0;
  for (size_t block = 0; block < kBlocks; ++block) {
    azimuths += read_u16(block_at(payload, block) + 2) <= kCentidegreesPerTurn;
  }
  return count_flags(payload) == kBlocks && azimuths > kBlocks / 2;
}

std::vector<lidar::LidarModel> lidar_models() {
  std::vector<lidar::LidarModel> list;
  for (const ModelInfo& info : models()) {
    list.push_back({.name = info.name,
                    .beams = info.lasers,
                    .calibrated_per_unit = info.calibrated_per_unit,
                    .has_dual_return = info.has_dual_return});
  }
  return list;
}

class Maker final : public lidar::LidarMaker {
 public:
  Maker() : LidarMaker("Velodyne", {.data = 2368, .information = 8308}, lidar_models()) {}

  lidar::PacketClass classify(std::span<const uint8_t> payload) const override {
    // A packet with a damaged block is the sensor's; random bytes of this size are nobody's.
    if (payload.size() == kPacketSize && count_flags(payload) >= kBlocks / 2) {
      return lidar::PacketClass::kData;
    }
    if (payload.size() == kPositionPacketSize) return lidar::PacketClass::kInformation;
    return lidar::PacketClass::kOther;
  }

  std::unique_ptr<lidar::ModelInference> make_inference() const override {
    return std::make_unique<ModelInference>();
  }

  Result<std::unique_ptr<lidar::LidarDecoder>> new_decoder(
      const lidar::DecoderOptions& options) const override {
    return std::make_unique<Decoder>(options);
  }

  Result<std::shared_ptr<const lidar::UnitCalibration>> load_calibration(
      const lidar::LidarModel& model, const std::filesystem::path& file) const override {
    const auto loaded = load_db_xml(file);
    if (!loaded) return tl::unexpected(loaded.error());
    const Model of_unit = model_of(model);
    if (const auto wrong = loaded->invalid(model_info(of_unit))) {
      return fail(*wrong, file.string(), "check that the file belongs to this model");
    }
    return std::make_shared<UnitCalibration>(of_unit, *loaded);
  }

  const char* calibration_file() const override { return "db.xml"; }

  std::optional<GnssFix> read_fix(const Datagram& datagram) const override {
    const auto packet = parse_position_packet(datagram.payload);
    if (!packet || !packet->sentence) return std::nullopt;
    return gnss::stamped_fix(*packet->sentence, datagram.stamp);
  }

  uint16_t first_azimuth(std::span<const uint8_t> payload) const override {
    return read_u16(payload.data() + 2);
  }

  lidar::RosPackets ros_packets() const override { return lidar::RosPackets::kVelodyneScan; }

  std::optional<lidar::FoundPacket> find_packet(std::span<const uint8_t> bytes) const override {
    if (bytes.size() >= kPacketSize && is_data_packet(bytes.first(kPacketSize))) {
      return lidar::FoundPacket{lidar::PacketClass::kData, kPacketSize, true};
    }
    if (bytes.size() >= kPositionPacketSize && bytes[kSentencePlace] == '$' &&
        parse_position_packet(bytes.first(kPositionPacketSize))) {
      return lidar::FoundPacket{lidar::PacketClass::kInformation, kPositionPacketSize, false};
    }
    return std::nullopt;
  }

  std::vector<uint8_t> example_packet(const lidar::LidarModel& model, uint32_t index,
                                      double radius) const override {
    const ModelInfo& info = model_info(model_of(model));
    if (info.banks > 1) return {};
    return velodyne::example_packet(info, index, radius);
  }

  Duration example_period(const lidar::LidarModel& model) const override {
    const ModelInfo& info = model_info(model_of(model));
    return packet_period(info, info.cycle, false);
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

std::optional<Model> find_model(std::string_view name) {
  const lidar::LidarMaker* const list[] = {&maker()};
  const lidar::LidarModel* found = lidar::find_model(list, name);
  return found != nullptr ? std::optional(model_of(*found)) : std::nullopt;
}

}  // namespace infuse::velodyne
