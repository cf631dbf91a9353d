#include "drivers/robosense/decoder.hpp"

#include <array>
#include <cstdlib>

#include "drivers/lidar/azimuth_table.hpp"
#include "drivers/robosense/robosense_maker.hpp"

namespace infuse::robosense {
namespace {

constexpr uint64_t kMinAgreeingSentences = 3;
constexpr int64_t kMaxSentenceDelayNs = 2'000'000'000;

const ModelInfo& info_of(const lidar::DecoderOptions& options) {
  return model_info(model_of(*options.model));
}

const UnitCalibration* unit_of(const lidar::DecoderOptions& options) {
  return static_cast<const UnitCalibration*>(options.calibration.get());
}

const Calibration& calibration_of(const lidar::DecoderOptions& options) {
  const UnitCalibration* unit = unit_of(options);
  return unit != nullptr ? unit->calibration : built_in_calibration(model_of(*options.model));
}

ClockModelOptions clock_options() {
  ClockModelOptions options;
  options.modulo = Duration(0);
  options.synchronised = ClockState::Source::kUtc;
  return options;
}

lidar::SequenceTiming timing_of(const BeamTable& table) {
  return {table.period_ns(), max_step(table.info())};
}

}  // namespace

Decoder::Decoder(const lidar::DecoderOptions& options)
    : LidarDecoder(options, clock_options(),
                   timing_of(BeamTable(model_of(*options.model), calibration_of(options), true))),
      info_(info_of(options)),
      table_(info_.model, calibration_of(options), options.single_origin),
      kernel_(return_kernel(options.instruction_set)),
      interpolate_(options.interpolate_azimuth) {
  if (unit_of(options) != nullptr) mode_ = unit_of(options)->mode;
}

std::shared_ptr<const lidar::UnitCalibration> Decoder::streamed_calibration() const {
  if (calibration_source() != lidar::CalibrationSource::kStream) return nullptr;
  return std::make_shared<UnitCalibration>(info_.model, calibration(), mode_);
}

/// The blocks of an RS-Helios show whether there are two returns; those of an RS-Helios-16P do not.
const char* Decoder::parse(std::span<const uint8_t> payload, lidar::PacketHeader& header) const {
  const auto packet = parse_packet(payload);
  if (!packet) return describe(packet.error());
  bool dual = table_.dual();
  if (!is_16p()) dual = packet->stands ? mode_ == ReturnMode::kDual : packet->repeats_azimuths;
  const size_t blocks = dual && !is_16p() ? 2 : 1;  // of one sequence
  header.counter = Duration(packet->time_ns);
  header.number = packet->number;
  header.mode = static_cast<uint16_t>(mode_of(dual));
  header.sequences = static_cast<uint8_t>(kBlocks / blocks);
  for (size_t i = 0; i < header.sequences; ++i) header.azimuth[i] = packet->azimuth[i * blocks];
  return nullptr;
}

/// What the sensor states, as far as the packets agree with it.
ReturnMode Decoder::mode_of(bool dual) const {
  if (dual) return ReturnMode::kDual;
  return mode_ && *mode_ != ReturnMode::kDual ? *mode_ : ReturnMode::kStrongest;
}

const char* Decoder::read_information(const Datagram& datagram) {
  const auto packet = parse_info_packet(datagram.payload);
  if (!packet) return "not an information packet";
  if (packet->mode) mode_ = packet->mode;
  Calibration unit = packet->calibration;
  unit.anticlockwise &= is_bpearl();
  if (!unit.invalid(info_) && calibration_source() != lidar::CalibrationSource::kFile) {
    set_calibration_source(lidar::CalibrationSource::kStream);
    if (unit != calibration()) table_.rebuild(unit, table_.dual());
  }
  if (packet->sentence) use(*packet->sentence, datagram.stamp);
  return nullptr;
}

void Decoder::use(const gnss::NmeaFix& sentence, Stamp stamp) {
  if (sentence.fix.utc_ns == last_sentence_ns_) return;
  last_sentence_ns_ = sentence.fix.utc_ns;
  give(gnss::stamped_fix(sentence, stamp));
  const bool agrees = sentence.has_date && sentence.fix.valid &&
                      std::abs(last_sentence_ns_ - newest_ns_) <= kMaxSentenceDelayNs;
  agreeing_sentences_ = agrees ? agreeing_sentences_ + 1 : 0;
  if (agreeing_sentences_ >= kMinAgreeingSentences) confirm_hour();
}

/// A packet of an RS-Helios-16P holds 24 firings of one return, or 12 of two: 1.33 or 0.67 ms.
void Decoder::observe(std::span<const uint8_t>, const lidar::PacketHeader& header,
                      const lidar::ArrivalOrder::Verdict& verdict) {
  constexpr int64_t kMinPacketNs = 500'000, kMaxDualNs = 1'000'000, kMaxPacketNs = 1'600'000;
  if (verdict.arrival == lidar::Arrival::kLate) return;
  const int64_t elapsed_ns = header.counter.count() - newest_ns_;
  const bool next = newest_number_ && header.number && *header.number == *newest_number_ + 1;
  newest_ns_ = header.counter.count();
  newest_number_ = header.number;
  if (!is_16p()) return;
  if (mode_) {
    set_dual(*mode_ == ReturnMode::kDual);
  } else if (next && elapsed_ns > kMinPacketNs && elapsed_ns < kMaxPacketNs) {
    set_dual(elapsed_ns < kMaxDualNs);
  }
}

void Decoder::set_dual(bool dual) {
  if (dual == table_.dual()) return;
  table_.rebuild(calibration(), dual);
  set_timing(timing_of(table_));
}

/// Angles and mode of the sensor before are not the other unit's own.
void Decoder::forget_unit() {
  mode_.reset();
  newest_number_.reset();
  if (calibration_source() != lidar::CalibrationSource::kStream) return;
  set_calibration_source(lidar::CalibrationSource::kBuiltIn);
  table_.rebuild(built_in_calibration(info_.model), table_.dual());
}

void Decoder::append(const lidar::HeldPacket& held, const lidar::FiringPlan& plan, size_t first,
                     size_t last, lidar::SweepWriter& writer) {
  static const lidar::AzimuthTable azimuths;
  const Packet packet = *parse_packet(held.payload);  // parsed before: there is no fault
  const auto stated = static_cast<ReturnMode>(held.header.mode);
  if (!is_16p()) set_dual(stated == ReturnMode::kDual);
  const bool dual = table_.dual();
  const size_t blocks = kBlocks / held.header.sequences;      // of a sequence
  const size_t firings_each = is_16p() && !dual ? 2 : 1;      // of a sequence
  const size_t firing_size = info_.lasers * kUnitSize;        // bytes
  const size_t stride = is_16p() ? firing_size : kBlockSize;  // to the second return
  const UnitLayout layout{.returns = static_cast<uint8_t>(dual ? 2 : 1),
                          .return_stride = static_cast<uint32_t>(stride),
                          .distance_unit = packet.distance_unit,
                          .kinds = return_kinds(mode_of(dual))};
  std::array<Firing, 2 * kBlocks> firings;
  size_t count = 0;
  for (size_t i = first; i < last; ++i) {
    const lidar::PlannedSequence& planned = plan.sequences[i];
    const auto place = writer.add_sequence(planned, held.device_ns + planned.time_ns,
                                           static_cast<uint16_t>(firings_each));
    const auto azimuth = azimuths.at(planned.azimuth);
    for (size_t k = 0; k < firings_each; ++k) {
      Firing& firing = firings[count++];
      firing.units = held.payload.data() + kHeaderSize + i * blocks * kBlockSize + kBlockPrefix +
                     k * firing_size;
      firing.row = table_.row(interpolate_ ? planned.step : uint16_t{0});
      firing.slot = k * info_.lasers;
      firing.cos_azimuth = azimuth.cos;
      firing.sin_azimuth = table_.side() * azimuth.sin;
      firing.column = static_cast<uint16_t>(place.column + k);
      firing.time_offset_ns = place.time_offset_ns;
    }
  }
  const auto arrays = writer.make_room(count * info_.lasers * layout.returns);
  writer.set_size(kernel_(table_, std::span(firings).first(count), layout, arrays, writer.size()),
                  table_.last_firing_ns());
}

}  // namespace infuse::robosense
