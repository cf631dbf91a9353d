#include "daemon/pipeline/intake.hpp"

namespace infuse::daemon {
namespace {

constexpr uint64_t kCaptureOverhead = 58;  // record header, Ethernet, IPv4 and UDP, bytes

}  // namespace

Intake::Intake(recording::DriveSource& source, const std::vector<LidarSetup>& lidars,
               std::optional<double> rate, SlotRing<StreamItem>& out)
    : source_(source), out_(out), pacer_(rate) {
  for (const LidarSetup& lidar : lidars) lidars_.emplace_back(lidar);
}

void Intake::run(std::stop_token stop) {
  recording::DriveEvent event;
  bool started = false;
  while (!stop.stop_requested() && source_.next(event)) {
    if (!started) hand_over(StreamItem::Kind::kStart, event.stamp);
    started = true;
    pacer_.wait_until(event.stamp, stop);
    taken_ = HostClock::now();
    ticker_.advance(event.stamp, [&](Stamp second) { hand_over_tick(second); });
    take(event);
  }
  for (size_t i = 0; i < lidars_.size(); ++i) {
    lidars_[i].finish([&](Sweep& sweep) { hand_over_sweep(static_cast<uint32_t>(i), sweep); });
  }
  if (started) hand_over_tick(event.stamp);
  hand_over(StreamItem::Kind::kEnd, event.stamp);
}

void Intake::take(const recording::DriveEvent& event) {
  // Pictures, CAN, IMU and GPS are for the methods to come; nothing listens to them yet.
  if (const auto* datagram = std::get_if<recording::DatagramEvent>(&event.content)) {
    take(*datagram);
  } else if (const auto* sweep = std::get_if<recording::SweepEvent>(&event.content)) {
    take(*sweep);
  }
}

void Intake::take(const recording::DatagramEvent& event) {
  const Datagram& datagram = event.datagram;
  capture_bytes_.fetch_add(datagram.payload.size() + kCaptureOverhead, std::memory_order_relaxed);
  if (event.lidar == recording::kNoLidar) {
    ++unclaimed_;
    stranger_ = datagram.sender;
    stranger_size_ = static_cast<uint32_t>(datagram.payload.size());
    return;
  }
  lidars_[event.lidar].take(
      datagram, [&](Sweep& sweep) { hand_over_sweep(static_cast<uint32_t>(event.lidar), sweep); });
}

void Intake::take(const recording::SweepEvent& event) {
  lidars_[event.lidar].take(*event.sweep, [&](Sweep& sweep) {
    hand_over_sweep(static_cast<uint32_t>(event.lidar), sweep);
  });
}

// The item in hand gets the full arrays and gives its own: nothing is copied.
void Intake::hand_over_sweep(uint32_t device, Sweep& sweep) {
  StreamItem& item = out_.hand();
  item.device = device;
  std::swap(item.sweep, sweep);
  latency_.add(HostClock::now() - taken_);
  hand_over(StreamItem::Kind::kSweep, item.sweep.stamp);
}

void Intake::hand_over_tick(Stamp stamp) {
  StreamItem& item = out_.hand();
  for (size_t i = 0; i < lidars_.size(); ++i) {
    SensorCounters& counters = item.counters[i];
    counters = lidars_[i].counters();
    counters.unclaimed = unclaimed_;
    if (counters.malformed + counters.wrong_sender > 0) continue;
    counters.stranger = stranger_;
    counters.stranger_size = stranger_size_;
  }
  item.intake = latency_.figures();
  hand_over(StreamItem::Kind::kTick, stamp);
}

void Intake::hand_over(StreamItem::Kind kind, Stamp stamp) {
  StreamItem& item = out_.hand();
  item.kind = kind;
  item.stamp = stamp;
  item.taken = taken_;
  out_.wait_for_room();
  out_.publish();
}

}  // namespace infuse::daemon
