#include "tests/study/months/simulated_lidar.hpp"

namespace infuse::study {
namespace {

constexpr int kPacketsPerSecond = 200;  // enough for the sender lock; a Velodyne sends more
constexpr int kBatch = 10;              // packets read together
constexpr int kClockStride = 20;        // packets of which one goes to the clock model
constexpr uint64_t kSweepsPerSecond = 10;
constexpr uint32_t kRival = 0x0A00'0063;        // 10.0.0.99
constexpr uint32_t kOtherSender = 0xC0A8'0105;  // 192.168.1.5
constexpr Duration kDelay{100'000};             // of a packet, at least
constexpr Duration kHour{3'600'000'000'000};

}  // namespace

SimulatedLidar::SimulatedLidar(std::string name, uint32_t address, uint32_t configured,
                               uint64_t seed)
    : name_(std::move(name)), address_(address), configured_(configured), random_(seed) {}

void SimulatedLidar::restart(const host::TimeBase& base) {
  stamps_ = host::WallStamps(base);
  clock_ = ClockModel(ClockModelOptions{});
  lock_ = lidar::SenderLock(configured_);
  counters_ = {};
  counters_.source.open_count = 1;
  delivers_ = false;
}

void SimulatedLidar::deliver(const SimulatedHost& host, const FaultSchedule& faults) {
  apply_events(host, faults);
  set_source(faults);
  delivers_ = false;
  if (!counters_.source.open || faults.has(name_, "silent")) return;
  const uint64_t before = counters_.packets;
  const Stamp begin = host.truth - from_seconds(1);
  for (int i = 0; i < kPacketsPerSecond; i += kBatch) {
    const auto time_of = [&](int packet) {
      return begin + from_seconds((packet + 0.5) / kPacketsPerSecond);
    };
    stamps_.update(host.read(time_of(i + kBatch - 1) + from_seconds(0.002)));
    for (int k = i; k < i + kBatch; ++k) receive(host, time_of(k), faults);
  }
  delivers_ = counters_.packets > before;
  if (!delivers_) return;
  if (faults.has(name_, "overload")) ++counters_.dropped_sweeps;
  if (faults.has(name_, "stopped")) return;
  counters_.sweeps += kSweepsPerSecond;
  counters_.returns += kSweepsPerSecond * 60'000;
}

void SimulatedLidar::apply_events(const SimulatedHost& host, const FaultSchedule& faults) {
  for (const Fault& fault : faults.begun()) {
    if (fault.subject != name_) continue;
    if (fault.kind == "jump") device_offset_ += from_seconds(fault.value);
    if (fault.kind == "swapped") ++address_;
    // It was off: its counter begins anew. Without a GNSS receiver it runs from then on.
    if (fault.kind == "unlocked") {
      device_offset_ = Duration(-(host.truth.ns() % kHour.count()));
    }
    if (fault.kind == "skew") skew_from_ = host.truth;
    if (fault.kind == "forged" && !lock_.accept(kRival, stamps_.last_update())) {  // one packet
      count_rejected(counters_.wrong_sender, 1, kRival);
    }
  }
}

void SimulatedLidar::set_source(const FaultSchedule& faults) {
  daemon::SourceState& source = counters_.source;
  const bool closed = faults.has(name_, "closed");
  if (source.open && closed) source.set_problem("cannot bind: the address is not there");
  if (!source.open && !closed) ++source.open_count;
  source.open = !closed;
  source.buffer_requested = 8 << 20;
  source.buffer_granted = faults.has(name_, "small_buffer") ? 212'992 : source.buffer_requested;
  counters_.two_sensors = faults.has(name_, "two_sensors");
}

/// The counter counts from the top of the hour.
Duration SimulatedLidar::device_time(Stamp time) const {
  const int64_t ns = (time.ns() + device_offset_.count()) % kHour.count();
  return Duration(ns < 0 ? ns + kHour.count() : ns);
}

bool SimulatedLidar::is_lost(double probability) {
  return std::uniform_real_distribution<double>(0, 1)(random_) < probability;
}

void SimulatedLidar::count_rejected(uint64_t& counter, uint64_t datagrams, uint32_t sender) {
  counter += datagrams;
  counters_.unexpected_sender = sender;
  counters_.unexpected_size = 1206;
}

void SimulatedLidar::receive(const SimulatedHost& host, Stamp time, const FaultSchedule& faults) {
  if (const Fault* loss = faults.find(name_, "loss"); loss != nullptr && is_lost(loss->value)) {
    ++counters_.lost_network;
    return;
  }
  if (const Fault* loss = faults.find(name_, "kernel_loss");
      loss != nullptr && is_lost(loss->value)) {
    ++counters_.lost_kernel;
    return;
  }
  const bool timed = ++sent_ % kClockStride == 0;
  Duration delay = kDelay;
  if (timed) {
    const Fault* jitter = faults.find(name_, "jitter");
    const double mean = jitter != nullptr ? jitter->value * 1e-3 : 0.1e-3;
    delay += from_seconds(mean * std::exponential_distribution<double>(1)(random_));
  }
  const Stamp stamp = stamps_.stamp_of(host.wall_at(time + delay).ns());
  if (faults.has(name_, "garbage")) return count_rejected(counters_.malformed, 1, address_);
  if (faults.has(name_, "others")) count_rejected(counters_.wrong_sender, 1, kOtherSender);
  if (faults.has(name_, "spoofed")) {
    const bool rival = !lock_.refuses(kRival) && lock_.accept(kRival, stamp);
    if (!rival) count_rejected(counters_.wrong_sender, 1, kRival);
  }
  const bool used = !lock_.refuses(address_) && lock_.accept(address_, stamp);
  counters_.sender = lock_.sender();
  counters_.previous_sender = lock_.previous();
  counters_.rival_sender = lock_.rival();
  counters_.sender_changes = lock_.changes();
  if (!used) return count_rejected(counters_.wrong_sender, 1, address_);
  if (counters_.packets == 0) counters_.first_packet = stamp;
  counters_.last_packet = stamp;
  ++counters_.packets;
  if (faults.has(name_, "wrong_model")) ++counters_.wrong_model;
  if (faults.has(name_, "stray")) ++counters_.stray_azimuths;
  if (faults.has(name_, "duplicates")) ++counters_.duplicates;
  if (faults.has(name_, "late")) ++counters_.out_of_order;
  if (!timed) return;
  double ppm = skew_ppm_;
  if (const Fault* skew = faults.find(name_, "skew")) ppm += skew->value;
  const Duration gained = from_seconds(to_seconds(time - skew_from_) * (ppm - skew_ppm_) * 1e-6);
  clock_.update(device_time(time + gained), stamp);
  counters_.clock = clock_.state();
  counters_.clock_jumps = clock_.state().jumps;
}

}  // namespace infuse::study
