#include "drivers/lidar/lidar_decoder.hpp"

#include "drivers/lidar/lidar_maker.hpp"

namespace infuse::lidar {
namespace {

constexpr uint64_t kPacketsPerComparison = 64;

/// What the assembler cannot use, as static text; null if nothing.
const char* find_impossible(const PacketHeader& header) {
  if (header.counter < Duration(0) || header.counter > kMaxCounter) {
    return "an impossible device time";
  }
  return header.sequences == 0 || header.sequences > kMaxSequences ? "no firing sequences"
                                                                   : nullptr;
}

}  // namespace

LidarDecoder::LidarDecoder(const DecoderOptions& options, const ClockModelOptions& clock,
                           const SequenceTiming& timing)
    : LidarDecoder(options, [&](PacketCounters& counters, Losses& losses) {
        ReturnReader& reader = *this;
        return std::make_unique<SweepAssembler>(options, clock, timing, reader, counters, losses);
      }) {}

LidarDecoder::LidarDecoder(const DecoderOptions& options, const MakeAssembler& make_assembler)
    : model_(*options.model),
      sender_(options.sender),
      assembler_(make_assembler(counters_, losses_)),
      inference_(model_.maker->make_inference()),
      calibration_source_(options.calibration != nullptr ? CalibrationSource::kFile
                                                         : CalibrationSource::kBuiltIn) {}

LidarDecoder::~LidarDecoder() = default;

const char* LidarDecoder::read_information(const Datagram&) {
  return "this model sends no information packets";
}

const char* LidarDecoder::read_inertial(const Datagram&) {
  return "this model sends no inertial packets";
}

void LidarDecoder::push(const Datagram& datagram) {
  const PacketClass packet_class = model_.maker->classify(datagram.payload);
  switch (packet_class) {
    case PacketClass::kInformation:
    case PacketClass::kInertial:
      return push_other(datagram, packet_class == PacketClass::kInertial);
    case PacketClass::kData:
    case PacketClass::kOther:
      return push_data(datagram, packet_class == PacketClass::kData);
  }
}

/// A datagram of another kind is refused as a data packet.
void LidarDecoder::push_data(const Datagram& datagram, bool data_packet) {
  assembler_->require_pulled();
  assembler_->resume();
  counters_.sender = sender_.sender();
  if (sender_.refuses(datagram.sender)) return reject_sender(datagram);
  PacketHeader header;
  const char* fault = parse(datagram.payload, header);
  if (fault == nullptr) fault = find_impossible(header);
  if (fault != nullptr) {
    if (sender_.sender() != 0 && datagram.sender != sender_.sender()) {
      return reject_sender(datagram);
    }
    if (data_packet) assembler_->note_refused();
    return refuse(datagram, fault);
  }
  if (!accept(datagram)) return reject_sender(datagram);
  const auto verdict = assembler_->push(datagram, header);
  if (!verdict) return;
  observe(datagram.payload, header, *verdict);
  inference_->add(datagram.payload);
  if (inference_->packets() >= compared_packets_ + kPacketsPerComparison) compare_model();
}

/// Asks the lock, and takes note of what it has decided.
bool LidarDecoder::accept(const Datagram& datagram) {
  const bool accepted = sender_.accept(datagram.sender, datagram.stamp);
  if (sender_.changes() != counters_.sender_changes) forget_unit();
  counters_.sender = sender_.sender();
  counters_.previous_sender = sender_.previous();
  counters_.rival_sender = sender_.rival();
  counters_.sender_changes = sender_.changes();
  return accepted;
}

void LidarDecoder::push_other(const Datagram& datagram, bool inertial) {
  if (sender_.sender() != 0 && datagram.sender != sender_.sender()) {
    return reject_sender(datagram);
  }
  const char* fault = inertial ? read_inertial(datagram) : read_information(datagram);
  if (fault != nullptr) return refuse(datagram, fault);
  if (!inertial) ++counters_.position_packets;
}

void LidarDecoder::refuse(const Datagram& datagram, const char* reason) {
  ++counters_.malformed;
  counters_.malformed_reason = reason;
  counters_.unexpected_sender = datagram.sender;
  counters_.unexpected_size = static_cast<uint32_t>(datagram.payload.size());
}

void LidarDecoder::reject_sender(const Datagram& datagram) {
  ++counters_.wrong_sender;
  counters_.unexpected_sender = datagram.sender;
  counters_.unexpected_size = static_cast<uint32_t>(datagram.payload.size());
}

void LidarDecoder::compare_model() {
  const LidarModel* judged = inference_->judge();
  if (judged != nullptr && judged != &model_) {
    counters_.wrong_model += inference_->packets() - compared_packets_;
  }
  compared_packets_ = inference_->packets();
  counters_.turns_hz = inference_->turns_per_second();
  counters_.turns_measured = inference_->packets() >= kPacketsPerComparison;
  counters_.two_sensors = inference_->has_two_sensors();
}

void LidarDecoder::finish() {
  compare_model();
  assembler_->finish();
}

}  // namespace infuse::lidar
