#include "drivers/velodyne/velodyne_maker.hpp"

#include <array>

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

/// True if bytes are a data packet of any model: all flags, most azimuths.
bool is_data_packet(std::span<const uint8_t> payload) {
  size_t azimuths = 0;
  for (size_t block = 0; block < kBlocks; ++block) {
    const uint8_t* bytes = block_at(payload, block);
    const uint8_t bank = bytes[1];
    const bool flag =
        bytes[0] == 0xFF && (bank == 0xEE || bank == 0xDD || bank == 0xCC || bank == 0xBB);
    if (!flag) return false;
    if (read_u16(bytes + 2) <= kCentidegreesPerTurn) ++azimuths;
  }
  return azimuths > kBlocks / 2;
}

class Maker final : public lidar::LidarMaker {
 public:
  Maker() {
    for (const ModelInfo& info : velodyne::models()) {
      models_[static_cast<size_t>(info.model)] = {.maker = this,
                                                  .name = info.name,
                                                  .beams = info.lasers,
                                                  .calibrated_per_unit = info.calibrated_per_unit,
                                                  .has_dual_return = info.has_dual_return};
    }
  }

  const char* name() const override { return "Velodyne"; }
  std::span<const lidar::LidarModel> models() const override { return models_; }

  lidar::PacketClass classify(std::span<const uint8_t> payload) const override {
    if (payload.size() == kPacketSize) return lidar::PacketClass::kData;
    if (payload.size() == kPositionPacketSize) return lidar::PacketClass::kInformation;
    return lidar::PacketClass::kOther;
  }

  std::unique_ptr<lidar::ModelInference> make_inference() const override {
    return std::make_unique<ModelInference>();
  }

  Result<std::unique_ptr<lidar::LidarDecoder>> make_decoder(
      const lidar::DecoderOptions& options) const override {
    if (const auto wrong = options.invalid()) return fail(*wrong, options.model->name);
    if (options.calibration != nullptr &&
        dynamic_cast<const UnitCalibration*>(options.calibration.get()) == nullptr) {
      return fail("the calibration is not a Velodyne's", options.model->name);
    }
    return std::make_unique<Decoder>(options);
  }

  Result<std::shared_ptr<const lidar::UnitCalibration>> load_calibration(
      const lidar::LidarModel& model, const std::filesystem::path& file) const override {
    const auto loaded = load_db_xml(file);
    if (!loaded) return tl::unexpected(loaded.error());
    if (const auto wrong = loaded->invalid(model_info(model_of(model)))) {
      return fail(*wrong, file.string(), "check that the file belongs to this model");
    }
    return std::make_shared<UnitCalibration>(*loaded);
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

  lidar::BeamPattern beam_pattern(const lidar::LidarModel& model) const override {
    const ModelInfo& info = model_info(model_of(model));
    const Calibration& calibration = built_in_calibration(info.model);
    const auto rings = calibration.rings(info);
    const auto times = firing_times(info, info.cycle);
    lidar::BeamPattern pattern{info.lasers, info.firings, sequence_period(info, info.cycle), {}};
    for (size_t i = 0; i < info.slots(); ++i) {
      const auto laser = static_cast<uint16_t>(i % info.lasers);
      const BeamCorrection& beam = calibration.beams[laser];
      pattern.slots.push_back({.beam = laser,
                               .ring = rings[laser],
                               .column = static_cast<uint16_t>(i / info.lasers),
                               .time_ns = times[i],
                               .elevation = beam.elevation,
                               .azimuth = -beam.rotation,
                               .right_offset = -beam.horizontal_offset,
                               .up_offset = beam.vertical_offset});
    }
    return pattern;
  }

 private:
  std::array<lidar::LidarModel, 7> models_;
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

std::optional<Model> find_model(std::string_view name) {
  const lidar::LidarMaker* const list[] = {&maker()};
  const lidar::LidarModel* found = lidar::find_model(list, name);
  return found != nullptr ? std::optional(model_of(*found)) : std::nullopt;
}

}  // namespace infuse::velodyne
