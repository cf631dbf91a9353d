#include "daemon/pipeline/lidar_intake.hpp"

#include <algorithm>

namespace infuse::daemon {
namespace {

constexpr uint64_t kPacketsPerJudgement = 64;
constexpr uint64_t kMinAgreeingSentences = 3;

}  // namespace

LidarIntake::LidarIntake(const LidarSetup& setup)
    : model_(velodyne::model_info(setup.assembler.model)), assembler_(setup.assembler) {}

void LidarIntake::push(const Datagram& datagram) {
  assembler_.push(datagram);
  const velodyne::PacketCounters& c = assembler_.counters();
  if (c.packets > counters_.packets) {
    note_packet(datagram.stamp);
    inference_.add(datagram.payload);
    if (inference_.packets() >= judged_packets_ + kPacketsPerJudgement) judge_model();
  }
  const uint64_t refused_before = counters_.malformed + counters_.wrong_sender;
  counters_.packets = c.packets;
  // The device's counter includes packets that the kernel dropped; these were not lost in the
  // network.
  const uint64_t before_kernel = c.network_lost - std::min(c.network_lost, c.kernel_dropped);
  counters_.lost_network = std::max(counters_.lost_network, before_kernel);
  counters_.outages = c.outages;
  counters_.lost_in_outages = std::min(c.lost_in_outages, counters_.lost_network);
  if (filtered_) {
    counters_.lost_kernel = std::max(counters_.lost_kernel, c.network_lost - before_kernel);
  }
  if (c.last_fault) counters_.malformed_reason = velodyne::describe(*c.last_fault);
  counters_.malformed = c.total_malformed() + refused_positions_;
  counters_.wrong_sender = c.wrong_sender + wrong_sender_positions_;
  const velodyne::SenderLock& sender = assembler_.sender();
  counters_.sender = sender.sender();
  counters_.previous_sender = sender.previous();
  counters_.rival_sender = sender.rival();
  counters_.sender_changes = sender.changes();
  counters_.stray_azimuths = c.stray_azimuths;
  counters_.duplicates = c.duplicates;
  counters_.out_of_order = c.out_of_order;
  counters_.too_late = c.too_late;
  counters_.clock_jumps = c.clock_jumps;
  counters_.clock = assembler_.clock();
  if (counters_.malformed + counters_.wrong_sender > refused_before)
    note_unexpected_sender(datagram);
}

void LidarIntake::judge_model() {
  const auto judged = inference_.judge();
  const bool is_other_model = judged && *judged != model_.model;
  if (is_other_model) counters_.wrong_model += inference_.packets() - judged_packets_;
  judged_packets_ = inference_.packets();
  counters_.turns_hz = inference_.turns_per_second();
  counters_.turns_measured = inference_.packets() >= kPacketsPerJudgement;
  counters_.two_sensors = inference_.has_two_sensors();
}

bool LidarIntake::is_uncalibrated() const {
  return model_.calibrated_per_unit &&
         assembler_.calibration_source() == velodyne::CalibrationSource::kBuiltIn;
}

LidarIntake::PositionContent LidarIntake::add_position_packet(const Datagram& datagram) {
  const uint32_t sender = assembler_.sender().sender();
  if (sender != 0 && datagram.sender != sender) {
    ++wrong_sender_positions_;
    ++counters_.wrong_sender;
    note_unexpected_sender(datagram);
    return {};
  }
  if (const auto packet = velodyne::parse_position_packet(datagram.payload)) {
    ++counters_.position_packets;
    const bool agrees = velodyne::counts_from_the_hour(*packet);
    agreeing_sentences_ = agrees ? agreeing_sentences_ + 1 : 0;
    if (agreeing_sentences_ >= kMinAgreeingSentences) assembler_.confirm_hour();
    return {new_fix(datagram, *packet), gyro_readings(datagram, *packet)};
  }
  ++refused_positions_;
  ++counters_.malformed;
  counters_.malformed_reason = "a position packet with an impossible state of PPS";
  note_unexpected_sender(datagram);
  return {};
}

// Other models leave the bytes empty.
std::optional<GyroReadings> LidarIntake::gyro_readings(
    const Datagram& datagram, const velodyne::PositionPacket& packet) const {
  if (model_.model != velodyne::Model::kHdl32e) return std::nullopt;
  GyroReadings readings;
  readings.stamp = datagram.stamp;
  for (size_t unit = 0; unit < packet.imu.size(); ++unit) {
    readings.rate[unit] = packet.imu[unit].angular_velocity;
  }
  return readings;
}

// Position packets repeat a sentence until the receiver sends the next one.
std::optional<GnssFix> LidarIntake::new_fix(const Datagram& datagram,
                                            const velodyne::PositionPacket& packet) {
  if (!packet.sentence || packet.sentence->fix.utc_ns == last_sentence_ns_) return std::nullopt;
  last_sentence_ns_ = packet.sentence->fix.utc_ns;
  return gnss::stamped_fix(*packet.sentence, datagram.stamp);
}

void LidarIntake::note_packet(Stamp stamp) {
  if (counters_.packets == 0) counters_.first_packet = stamp;
  counters_.last_packet = stamp;
}

void LidarIntake::note_unexpected_sender(const Datagram& datagram) {
  counters_.unexpected_sender = datagram.sender;
  counters_.unexpected_size = static_cast<uint32_t>(datagram.payload.size());
}

}  // namespace infuse::daemon
