#include "drivers/velodyne/decoder.hpp"

#include <algorithm>
#include <array>

#include "drivers/gnss/nmea.hpp"
#include "drivers/lidar/azimuth_table.hpp"
#include "drivers/velodyne/beam_origins.hpp"
#include "drivers/velodyne/packet.hpp"
#include "drivers/velodyne/position_packet.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

namespace infuse::velodyne {
namespace {

constexpr uint64_t kMinAgreeingSentences = 3;

EchoKinds echo_kinds(const ModelInfo& info, ReturnMode mode) {
  switch (mode) {
    case ReturnMode::kStrongest:
      return {ReturnKind::kStrongest, ReturnKind::kLast};
    case ReturnMode::kLast:
      return {ReturnKind::kLast, ReturnKind::kStrongest};
    case ReturnMode::kDual:
      break;
  }
  return info.calibrated_per_unit ? EchoKinds{ReturnKind::kStrongest, ReturnKind::kLast}
                                  : EchoKinds{ReturnKind::kLast, ReturnKind::kStrongest};
}

Calibration calibration_of(const lidar::DecoderOptions& options) {
  const Model model = model_of(*options.model);
  if (options.single_origin && !options.model->calibrated_per_unit) {
    return single_origin_calibration(model);
  }
  if (options.calibration == nullptr) return built_in_calibration(model);
  return static_cast<const UnitCalibration&>(*options.calibration).calibration;
}

lidar::SequenceTiming timing_of(const ModelInfo& info, Duration cycle) {
  return {sequence_period(info, cycle).count(), max_azimuth_step(info)};
}

const ModelInfo& info_of(const lidar::DecoderOptions& options) {
  return model_info(model_of(*options.model));
}

}  // namespace

Decoder::Decoder(const lidar::DecoderOptions& options)
    : LidarDecoder(options, ClockModelOptions(),
                   timing_of(info_of(options), info_of(options).cycle)),
      info_(info_of(options)),
      calibration_(calibration_of(options)),
      table_(info_.model, calibration_, info_.cycle),
      calibration_stream_(info_.model),
      cycle_estimator_(info_),
      kernel_(return_kernel(options.instruction_set)),
      interpolate_(options.interpolate_azimuth) {}

std::shared_ptr<const lidar::UnitCalibration> Decoder::streamed_calibration() const {
  if (calibration_source() != lidar::CalibrationSource::kStream) return nullptr;
  return std::make_shared<UnitCalibration>(info_.model, calibration_);
}

const char* Decoder::parse(std::span<const uint8_t> payload, lidar::PacketHeader& header) const {
  const auto packet = parse_packet(info_, payload);
  if (!packet) return describe(packet.error());
  header.counter = std::chrono::microseconds(packet->counter_us);
  header.mode = static_cast<uint16_t>(packet->mode);
  header.sequences = packet->sequences;
  std::copy(packet->azimuth.begin(), packet->azimuth.end(), header.azimuth.begin());
  return nullptr;
}

const char* Decoder::read_information(const Datagram& datagram) {
  const auto packet = parse_position_packet(datagram.payload);
  if (!packet) return "a position packet with an impossible state of PPS";
  agreeing_sentences_ = counts_from_the_hour(*packet) ? agreeing_sentences_ + 1 : 0;
  if (agreeing_sentences_ >= kMinAgreeingSentences) confirm_hour();
  // Position packets repeat a sentence until the receiver sends the next one.
  if (packet->sentence && packet->sentence->fix.utc_ns != last_sentence_ns_) {
    last_sentence_ns_ = packet->sentence->fix.utc_ns;
    give(gnss::stamped_fix(*packet->sentence, datagram.stamp));
  }
  if (info_.model != Model::kHdl32e) return nullptr;  // other models leave the bytes empty
  GyroReadings readings;
  readings.stamp = datagram.stamp;
  for (size_t unit = 0; unit < packet->imu.size(); ++unit) {
    readings.rate[unit] = packet->imu[unit].angular_velocity;
  }
  give(readings);
  return nullptr;
}

void Decoder::observe(std::span<const uint8_t> payload, const lidar::PacketHeader& header,
                      const lidar::ArrivalOrder::Verdict& verdict) {
  const bool next = verdict.arrival == lidar::Arrival::kNext;
  const bool dual = static_cast<ReturnMode>(header.mode) == ReturnMode::kDual;
  if (info_.calibrated_per_unit && calibration_source() == lidar::CalibrationSource::kBuiltIn) {
    const Duration period = packet_period(info_, info_.cycle, dual);
    if (!next || verdict.delay > period * 3 / 2) calibration_stream_.restart();
    if (const auto streamed =
            calibration_stream_.add(payload[kReturnModeOffset], payload[kProductIdOffset])) {
      calibration_ = *streamed;
      set_calibration_source(lidar::CalibrationSource::kStream);
      table_.rebuild(calibration_, table_.cycle);
    }
  }
  if (info_.model == Model::kVls128 && next) {
    if (const auto cycle = cycle_estimator_.add(verdict.delay.count() / 1000, dual)) {
      table_.rebuild(calibration_, *cycle);
      set_timing(timing_of(info_, *cycle));
    }
  }
}

/// The calibration that the stream contained is not the other unit's own.
void Decoder::forget_unit() {
  if (calibration_source() == lidar::CalibrationSource::kStream) {
    set_calibration_source(lidar::CalibrationSource::kBuiltIn);
  }
  calibration_stream_.restart();
}

void Decoder::append(const lidar::HeldPacket& packet, const lidar::FiringPlan& plan, size_t first,
                     size_t last, lidar::SweepWriter& writer) {
  static const lidar::AzimuthTable azimuths;
  const auto mode = static_cast<ReturnMode>(packet.header.mode);
  const bool dual = mode == ReturnMode::kDual;
  const BlockLayout layout = block_layout(info_, dual);
  std::array<SequenceBlocks, kBlocks> blocks;
  size_t count = 0;
  for (size_t i = first; i < last; ++i) {
    const lidar::PlannedSequence& planned = plan.sequences[i];
    const auto azimuth = azimuths.at(planned.azimuth);
    const auto place =
        writer.add_sequence(planned, packet.device_ns + planned.time_ns, info_.firings);
    SequenceBlocks& sequence = blocks[count++];
    sequence.returns = packet.payload.data() + layout.block(i, 0, 0) * kBlockSize + 4;
    sequence.bank_stride = static_cast<uint32_t>(layout.bank * kBlockSize);
    sequence.echo_stride = static_cast<uint32_t>(layout.echo * kBlockSize);
    sequence.cos_azimuth = azimuth.cos;
    sequence.sin_azimuth = azimuth.sin;
    sequence.step = interpolate_ ? planned.step : uint16_t{0};
    sequence.column = place.column;
    sequence.time_offset_ns = place.time_offset_ns;
  }
  const ReturnArrays arrays = writer.make_room(count * info_.slots() * (dual ? 2 : 1));
  const size_t size = kernel_(table_, std::span(blocks).first(count), echo_kinds(info_, mode),
                              arrays, writer.size());
  writer.set_size(size, table_.last_firing_ns);
}

}  // namespace infuse::velodyne
