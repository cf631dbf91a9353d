#include "drivers/hesai/hesai_maker.hpp"

#include <array>

#include "drivers/gnss/nmea.hpp"
#include "drivers/hesai/calibration_file.hpp"
#include "drivers/hesai/decoder.hpp"
#include "drivers/hesai/firing_times.hpp"
#include "drivers/hesai/gps_packet.hpp"
#include "drivers/hesai/model_inference.hpp"
#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/lidar/little_endian.hpp"

namespace infuse::hesai {
namespace {

class Maker final : public lidar::LidarMaker {
 public:
  Maker() {
    for (const ModelInfo& info : hesai::models()) {
      models_[static_cast<size_t>(info.model)] = {.maker = this,
                                                  .name = info.name,
                                                  .beams = info.lasers,
                                                  .calibrated_per_unit = false,
                                                  .has_dual_return = true};
    }
  }

  const char* name() const override { return "Hesai"; }
  std::span<const lidar::LidarModel> models() const override { return models_; }

  lidar::PacketClass classify(std::span<const uint8_t> payload) const override {
    if (looks_like_hesai(payload)) return lidar::PacketClass::kData;
    if (is_gps_packet(payload)) return lidar::PacketClass::kInformation;
    return lidar::PacketClass::kOther;
  }

  std::unique_ptr<lidar::ModelInference> make_inference() const override {
    return std::make_unique<ModelInference>();
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

  Result<std::shared_ptr<const lidar::UnitCalibration>> load_calibration(
      const lidar::LidarModel& model, const std::filesystem::path& file) const override {
    const Model of_unit = model_of(model);
    const auto loaded = load_angle_csv(file, model_info(of_unit));
    if (!loaded) return tl::unexpected(loaded.error());
    return std::make_shared<UnitCalibration>(of_unit, *loaded);
  }

  lidar::LidarPorts ports() const override { return {.data = 2368, .information = 10110}; }

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

  lidar::BeamPattern beam_pattern(const lidar::LidarModel& model) const override {
    const ModelInfo& info = model_info(model_of(model));
    if (number_of_loops(info.model) > 1) return {};
    const Calibration& calibration = built_in_calibration(info.model);
    const auto rings = calibration.rings(info);
    const FiringTimes times = firing_times(info.model, 0);
    lidar::BeamPattern pattern{info.lasers, 1, info.period, {}};
    for (uint16_t channel = 0; channel < info.lasers; ++channel) {
      const BeamAngles& beam = calibration.beams[channel];
      pattern.slots.push_back({.beam = channel,
                               .ring = rings[channel],
                               .time_ns = times.channel_ns[channel] - times.first_ns,
                               .elevation = beam.elevation,
                               .azimuth = beam.azimuth_offset});
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

}  // namespace infuse::hesai
