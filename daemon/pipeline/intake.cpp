#include "daemon/pipeline/intake.hpp"

namespace infuse::daemon {

Intake::Intake(const PipelineSetup& setup, SlotRing<StreamItem>& out)
    : delivery_(setup.delivery),
      cameras_(setup.cameras.size()),
      mounted_cameras_(setup.rig.cameras.size()),
      vehicle_(setup.vehicle),
      out_(out) {
  for (const LidarSetup& lidar : setup.lidars) lidars_.emplace_back(lidar);
  samples_.reserve(kSamplesTogether);
}

void Intake::start(Stamp stamp) { hand_over(StreamItem::Kind::kStart, stamp); }

void Intake::advance(Stamp stamp) {
  taken_ = HostClock::now();
  ticker_.advance(stamp, [&](Stamp second) { hand_over_tick(second); });
}

void Intake::end(Stamp stamp, bool started) {
  for (size_t i = 0; i < lidars_.size(); ++i) {
    lidars_[i].finish([&](Sweep& sweep) { hand_over_sweep(i, sweep); });
  }
  if (started) {
    hand_over_samples();
    hand_over(StreamItem::Kind::kLast, stamp);
    hand_over_tick(stamp);
  }
  hand_over(StreamItem::Kind::kEnd, stamp);
}

void Intake::take(size_t lidar, const Datagram& datagram) {
  lidars_[lidar].take(datagram, [&](Sweep& sweep) { hand_over_sweep(lidar, sweep); });
}

void Intake::take_unclaimed(const Datagram& datagram) {
  ++unclaimed_;
  stranger_ = datagram.sender;
  stranger_size_ = static_cast<uint32_t>(datagram.payload.size());
}

void Intake::take(size_t lidar, const Sweep& sweep) {
  lidars_[lidar].take(sweep, [&](Sweep& done) { hand_over_sweep(lidar, done); });
}

void Intake::take_file(size_t camera, Stamp stamp, uint64_t sequence,
                       const std::filesystem::path& path) {
  hand_over_samples();
  StreamItem& item = out_.hand();
  if (!cameras_[camera].take(stamp, sequence, path, item.encoded)) return;
  item.raw.reset();
  hand_over_picture(camera, stamp, sequence);
}

void Intake::take(size_t camera, const camera::StreamedPicture& picture) {
  cameras_[camera].count(picture.stamp, picture.sequence);
  if (camera >= mounted_cameras_) return;
  hand_over_samples();
  StreamItem& item = out_.hand();
  item.encoded.assign(picture.raw.bytes.begin(), picture.raw.bytes.end());
  item.raw = picture;
  item.raw->raw.bytes = {};
  hand_over_picture(camera, picture.stamp, picture.sequence);
}

void Intake::take_line(std::string_view line, Stamp stamp) {
  vehicle_.take_line(line, stamp, [&](const VehicleSample& sample) { add(sample, stamp); });
}

void Intake::take(size_t bus, const vehicle::CanFrame& frame) {
  vehicle_.take_frame(bus, frame, [&](const VehicleSample& sample) { add(sample, frame.stamp); });
}

void Intake::take(const ImuSample& sample, Stamp stamp) {
  vehicle_.count(sample);
  add(sample, stamp);
}

void Intake::take(const GpsFix& fix, Stamp stamp) {
  vehicle_.count(fix);
  add(fix, stamp);
}

void Intake::hand_over_old_samples(Stamp now) {
  if (!samples_.empty() && now - first_sample_ >= kSamplesWithin) hand_over_samples();
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
void Intake::hand_over_sweep(size_t device, Sweep& sweep) {
  hand_over_samples();
  StreamItem& item = out_.hand();
  item.device = static_cast<uint32_t>(device);
  std::swap(item.sweep, sweep);
  latency_.add(HostClock::now() - taken_);
  hand_over(StreamItem::Kind::kSweep, item.sweep.stamp);
}

void Intake::hand_over_picture(size_t camera, Stamp stamp, uint64_t sequence) {
  StreamItem& item = out_.hand();
  item.camera = static_cast<uint32_t>(camera);
  item.number = pictures_++;
  item.sequence = sequence;
  latency_.add(HostClock::now() - taken_);
  hand_over(StreamItem::Kind::kPicture, stamp);
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
  size_t stream = 0;  // in the order of PipelineSetup::devices
  for (const CameraIntake& camera : cameras_) item.streams[stream++] = camera.counters();
  vehicle_.write_counters(item.streams.data() + stream);
  sources_.write(item.counters, item.streams);
  item.intake = latency_.figures();
  hand_over(StreamItem::Kind::kTick, stamp);
}

void Intake::hand_over(StreamItem::Kind kind, Stamp stamp) {
  StreamItem& item = out_.hand();
  item.kind = kind;
  item.stamp = stamp;
  item.taken = taken_;
  deliver(out_, delivery_);
}

}  // namespace infuse::daemon
