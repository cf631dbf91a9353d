#include "daemon/pipeline/intake.hpp"

namespace infuse::daemon {
namespace {

constexpr uint64_t kCaptureOverhead = 58;  // record header, Ethernet, IPv4 and UDP, bytes

}  // namespace

Intake::Intake(DriveSetup& setup, std::optional<double> rate, SlotRing<StreamItem>& out)
    : source_(setup.source),
      cameras_(setup.rig.cameras.size()),
      vehicle_(std::move(setup.vehicle.decoder)),
      has_can_(setup.has_can),
      has_imu_(setup.vehicle.has_imu),
      has_gps_(setup.vehicle.has_gps),
      out_(out),
      pacer_(rate) {
  for (const LidarSetup& lidar : setup.lidars) lidars_.emplace_back(lidar);
  samples_.reserve(kSamplesTogether);
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
  if (const auto* datagram = std::get_if<recording::DatagramEvent>(&event.content)) {
    take(*datagram);
  } else if (const auto* sweep = std::get_if<recording::SweepEvent>(&event.content)) {
    take(*sweep);
  } else if (const auto* image = std::get_if<recording::ImageEvent>(&event.content)) {
    take(*image, event.stamp);
  } else if (const auto* bus = std::get_if<recording::CanLineEvent>(&event.content)) {
    vehicle_.take_line(bus->line, event.stamp,
                       [&](const VehicleSample& sample) { add(sample, event.stamp); });
  } else if (const auto* imu = std::get_if<ImuSample>(&event.content)) {
    vehicle_.count(*imu);
    add(*imu, event.stamp);
  } else if (const auto* fix = std::get_if<GpsFix>(&event.content)) {
    vehicle_.count(*fix);
    add(*fix, event.stamp);
  }
  if (!samples_.empty() && event.stamp - first_sample_ >= kSamplesWithin) hand_over_samples();
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

void Intake::take(const recording::ImageEvent& event, Stamp stamp) {
  hand_over_samples();
  StreamItem& item = out_.hand();
  if (!cameras_[event.camera].take(stamp, event.sequence, *event.path, item.encoded)) return;
  item.camera = static_cast<uint32_t>(event.camera);
  item.number = pictures_++;
  item.sequence = event.sequence;
  latency_.add(HostClock::now() - taken_);
  hand_over(StreamItem::Kind::kPicture, stamp);
}

void Intake::add(const VehicleSample& sample, Stamp stamp) {
  if (samples_.empty()) first_sample_ = stamp;
  last_sample_ = stamp;
  samples_.push_back(sample);
  if (samples_.size() == kSamplesTogether) hand_over_samples();
}

// Many small samples would wake the fusion thread for each; they come before whatever follows them.
void Intake::hand_over_samples() {
  if (samples_.empty()) return;
  std::swap(out_.hand().samples, samples_);
  samples_.clear();
  hand_over(StreamItem::Kind::kSamples, last_sample_);
}

// The item in hand gets the full arrays and gives its own: nothing is copied.
void Intake::hand_over_sweep(uint32_t device, Sweep& sweep) {
  hand_over_samples();
  StreamItem& item = out_.hand();
  item.device = device;
  std::swap(item.sweep, sweep);
  latency_.add(HostClock::now() - taken_);
  hand_over(StreamItem::Kind::kSweep, item.sweep.stamp);
}

void Intake::hand_over_tick(Stamp stamp) {
  hand_over_samples();
  StreamItem& item = out_.hand();
  for (size_t i = 0; i < lidars_.size(); ++i) {
    SensorCounters& counters = item.counters[i];
    counters = lidars_[i].counters();
    counters.unclaimed = unclaimed_;
    if (counters.malformed + counters.wrong_sender > 0) continue;
    counters.stranger = stranger_;
    counters.stranger_size = stranger_size_;
  }
  size_t stream = 0;  // in the order of DriveSetup::devices
  for (const CameraIntake& camera : cameras_) item.streams[stream++] = camera.counters();
  if (has_can_) item.streams[stream++] = vehicle_.can();
  if (has_imu_) item.streams[stream++] = vehicle_.imu();
  if (has_gps_) item.streams[stream++] = vehicle_.gps();
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
