#include "drivers/hesai/decoder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "drivers/gnss/nmea.hpp"
#include "drivers/hesai/gps_packet.hpp"
#include "drivers/hesai/hesai_maker.hpp"
#include "drivers/lidar/azimuth_table.hpp"

namespace infuse::hesai {
namespace {

constexpr uint64_t kMinAgreeingSentences = 3;
constexpr int64_t kMaxSentenceDelayNs = 2'000'000'000;

const ModelInfo& info_of(const lidar::DecoderOptions& options) {
  return model_info(model_of(*options.model));
}

const Calibration& calibration_of(const lidar::DecoderOptions& options) {
  if (options.calibration == nullptr) return built_in_calibration(model_of(*options.model));
  return static_cast<const UnitCalibration&>(*options.calibration).calibration;
}

lidar::SequenceTiming timing_of(const ModelInfo& info) {
  constexpr double kMaxTurnsPerSecond = 30;
  const double max_step =
      kMaxTurnsPerSecond * lidar::kCentidegreesPerTurn * to_seconds(info.period);
  return {info.period.count(), static_cast<int>(std::ceil(max_step))};
}

ClockModelOptions clock_options() {
  ClockModelOptions options;
  options.modulo = Duration(0);
  options.synchronised = ClockState::Source::kUtc;
  return options;
}

}  // namespace

Decoder::Decoder(const lidar::DecoderOptions& options)
    : LidarDecoder(options, clock_options(), timing_of(info_of(options))),
      info_(info_of(options)),
      table_(info_.model, calibration_of(options)),
      kernel_(return_kernel(options.instruction_set)),
      interpolate_(options.interpolate_azimuth) {}

const char* Decoder::parse(std::span<const uint8_t> payload, lidar::PacketHeader& header) const {
  const auto packet = parse_packet(info_, payload);
  if (!packet) return describe(packet.error());
  const int64_t first_ns = packet->utc_ns + block_time_ns(info_.model, *packet, 0) +
                           table_.firing(packet->loop).first_ns;
  header.counter = Duration(std::max<int64_t>(first_ns, 0));
  header.number = packet->number;
  header.mode = static_cast<uint16_t>(packet->mode);
  header.sequences = packet->sequences;
  std::copy_n(packet->azimuth.begin(), packet->sequences, header.azimuth.begin());
  return nullptr;
}

const char* Decoder::read_information(const Datagram& datagram) {
  const auto packet = parse_gps_packet(datagram.payload);
  if (!packet) return "not a GPS packet";
  if (!packet->sentence || packet->sentence->fix.utc_ns == last_sentence_ns_) return nullptr;
  last_sentence_ns_ = packet->sentence->fix.utc_ns;
  give(gnss::stamped_fix(*packet->sentence, datagram.stamp));
  const bool agrees = packet->sentence->has_date && packet->sentence->fix.valid &&
                      std::abs(last_sentence_ns_ - newest_utc_ns_) <= kMaxSentenceDelayNs;
  agreeing_sentences_ = agrees ? agreeing_sentences_ + 1 : 0;
  if (agreeing_sentences_ >= kMinAgreeingSentences) confirm_hour();
  return nullptr;
}

void Decoder::observe(std::span<const uint8_t>, const lidar::PacketHeader& header,
                      const lidar::ArrivalOrder::Verdict&) {
  newest_utc_ns_ = header.counter.count();
}

void Decoder::append(const lidar::HeldPacket& held, const lidar::FiringPlan& plan, size_t first,
                     size_t last, lidar::SweepWriter& writer) {
  static const lidar::AzimuthTable azimuths;
  const Packet packet = *parse_layout(info_, held.payload);  // parsed before: there is no fault
  const uint16_t speed = interpolate_ ? packet.motor_speed : uint16_t{0};
  const UnitLayout layout{.unit_size = info_.unit_size,
                          .returns = packet.returns,
                          .block_size = static_cast<uint32_t>(info_.block_size()),
                          .distance_unit = static_cast<float>(packet.distance_unit_mm * 1e-3),
                          .kinds = return_kinds(info_.model, packet.mode)};
  const uint8_t* units = held.payload.data() + info_.header_size + info_.block_prefix;
  std::array<Firing, kMaxBlocks> firings;
  size_t count = 0;
  int32_t last_firing_ns = 0;
  for (size_t i = first; i < last; ++i) {
    const lidar::PlannedSequence& planned = plan.sequences[i];
    const size_t loop = (packet.loop + i) % number_of_loops(info_.model);
    const auto place = writer.add_sequence(planned, held.device_ns + planned.time_ns, 1);
    const auto azimuth = azimuths.at(planned.azimuth);
    Firing& firing = firings[count++];
    firing.units = units + i * packet.returns * info_.block_size();
    firing.row = table_.row(speed, loop);
    firing.time_ns = table_.times(loop);
    firing.cos_azimuth = azimuth.cos;
    firing.sin_azimuth = azimuth.sin;
    firing.column = place.column;
    firing.time_offset_ns = place.time_offset_ns;
    last_firing_ns = table_.firing(loop).last_ns - table_.firing(loop).first_ns;
  }
  const auto arrays = writer.make_room(count * info_.lasers * packet.returns);
  writer.set_size(kernel_(table_, std::span(firings).first(count), layout, arrays, writer.size()),
                  last_firing_ns);
}

}  // namespace infuse::hesai
