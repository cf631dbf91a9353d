#include "daemon/pipeline/intake.hpp"

#include "daemon/pipeline/datagram_batch.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxDatagramBytes = size_t{512} << 10;  // of a batch

}  // namespace

Intake::Intake(const SensorSetup& setup, SlotRing<StreamItem>& out, const PipelineTap* tap)
    : delivery_(delivery_of(setup.live)),
      cameras_(setup.cameras.size()),
      mounted_cameras_(setup.rig.cameras.size()),
      vehicle_(setup.vehicle),
      gnss_lidar_(setup.gnss_lidar),
      out_(out),
      tap_(tap),
      datagrams_(setup.lidars.size()),
      last_datagrams_(setup.lidars.size()) {
  for (const LidarSetup& lidar : setup.lidars) lidars_.emplace_back(lidar);
  samples_.reserve(kMaxSampleBatch);
  from_bus_.reserve(kMaxSampleBatch);
}

void Intake::start(Stamp stamp) { push_item(StreamItem::Kind::kStart, stamp); }

void Intake::advance(Stamp stamp) {
  read_at_ = HostClock::now();
  ticker_.advance(stamp, [&](Stamp second) { push_tick(second); });
}

void Intake::end(Stamp stamp, bool started) {
  for (size_t i = 0; i < lidars_.size(); ++i) {
    lidars_[i].finish([&](Sweep& sweep) { push_sweep(LidarIndex(i), sweep); });
    push_datagrams(LidarIndex(i));
  }
  if (started) {
    push_samples();
    push_item(StreamItem::Kind::kFlush, stamp);
    push_tick(stamp);
  }
  push_item(StreamItem::Kind::kEnd, stamp);
}

void Intake::keep_datagram(LidarIndex lidar, const Datagram& datagram) {
  std::vector<uint8_t>& batch = datagrams_[lidar];
  append_datagram(batch, datagram.stamp, datagram.payload);
  last_datagrams_[lidar] = datagram.stamp;
  if (batch.size() >= kMaxDatagramBytes) push_datagrams(lidar);
}

void Intake::push_datagrams(LidarIndex lidar) {
  if (datagrams_[lidar].empty()) return;
  StreamItem& item = out_.slot();
  item.lidar = lidar;
  std::swap(item.datagrams, datagrams_[lidar]);
  datagrams_[lidar].clear();
  push_item(StreamItem::Kind::kDatagrams, last_datagrams_[lidar]);
}

void Intake::add_datagram(LidarIndex lidar, const Datagram& datagram) {
  if (tap_ != nullptr && tap_->wants_datagrams(lidar)) keep_datagram(lidar, datagram);
  lidars_[lidar].add_datagram(
      datagram, [&](Sweep& sweep) { push_sweep(lidar, sweep); },
      [&](const GnssFix& fix) {
        if (gnss_lidar_ == lidar) add_gnss(fix, datagram.stamp);
      },
      [&](const GyroReadings& readings) {
        // Their axes are found by the motion that the first lidar measures.
        if (lidar == LidarIndex(0)) add_vehicle_sample(readings, datagram.stamp, false);
      },
      [&](const ImuSample& sample) {
        // The filter has the biases of one unit only: the vehicle's, or the first lidar's.
        if (lidar != LidarIndex(0) || vehicle_.has_inertial_unit()) return;
        add_vehicle_sample(sample, datagram.stamp, false);
      });
}

void Intake::add_unclaimed_datagram(const Datagram& datagram) {
  ++unclaimed_;
  unexpected_sender_ = datagram.sender;
  unexpected_size_ = static_cast<uint32_t>(datagram.payload.size());
}

void Intake::add_sweep(LidarIndex lidar, const Sweep& sweep) {
  lidars_[lidar].add_sweep(sweep, [&](Sweep& done) { push_sweep(lidar, done); });
}

void Intake::add_image_file(CameraIndex camera, Stamp stamp, uint64_t sequence,
                            const std::filesystem::path& path) {
  push_samples();
  StreamItem& item = out_.slot();
  if (!cameras_[camera].read_image(stamp, sequence, path, item.encoded)) return;
  item.raw.reset();
  push_image(camera, stamp, sequence);
}

void Intake::add_streamed_image(CameraIndex camera, const camera::StreamedImage& image) {
  cameras_[camera].count(image.stamp, image.sequence);
  if (camera >= mounted_cameras_) return;
  push_samples();
  StreamItem& item = out_.slot();
  item.encoded.assign(image.raw.bytes.begin(), image.raw.bytes.end());
  item.raw = image;
  item.raw->raw.bytes = {};
  push_image(camera, image.stamp, image.sequence);
}

void Intake::add_can_line(std::string_view line, Stamp stamp) {
  vehicle_.add_can_line(
      line, stamp, [&](const VehicleSample& sample) { add_vehicle_sample(sample, stamp, true); });
}

void Intake::add_can_frame(BusIndex bus, const vehicle::CanFrame& frame) {
  vehicle_.add_can_frame(bus, frame, [&](const VehicleSample& sample) {
    add_vehicle_sample(sample, frame.stamp, true);
  });
}

void Intake::add_speed(const WheelOdometry& sample, Stamp stamp) {
  vehicle_.count(sample);
  add_vehicle_sample(sample, stamp, false);
}

void Intake::add_imu(const ImuSample& sample, Stamp stamp) {
  vehicle_.count(sample);
  add_vehicle_sample(sample, stamp, false);
}

void Intake::add_gnss(const GnssFix& fix, Stamp stamp) {
  vehicle_.count(fix);
  add_vehicle_sample(fix, stamp, false);
}

void Intake::push_due_samples(Stamp now) {
  if (!samples_.empty() && now - first_sample_ >= kMaxSampleDelay) push_samples();
}

void Intake::add_vehicle_sample(const VehicleSample& sample, Stamp stamp, bool from_bus) {
  if (samples_.empty()) first_sample_ = stamp;
  last_sample_ = stamp;
  samples_.push_back(sample);
  from_bus_.push_back(from_bus ? 1 : 0);
  if (samples_.size() == kMaxSampleBatch) push_samples();
}

// Samples are batched, so that they do not wake the fusion thread one by one. They precede the item
// that follows them.
void Intake::push_samples() {
  if (samples_.empty()) return;
  std::swap(out_.slot().samples, samples_);
  std::swap(out_.slot().from_bus, from_bus_);
  samples_.clear();
  from_bus_.clear();
  push_item(StreamItem::Kind::kSamples, last_sample_);
}

// Swaps arrays with the item: nothing is copied.
void Intake::push_sweep(LidarIndex lidar, Sweep& sweep) {
  push_samples();
  push_datagrams(lidar);
  StreamItem& item = out_.slot();
  item.lidar = lidar;
  std::swap(item.sweep, sweep);
  latency_.add(HostClock::now() - read_at_);
  push_item(StreamItem::Kind::kSweep, item.sweep.stamp);
}

void Intake::push_image(CameraIndex camera, Stamp stamp, uint64_t sequence) {
  StreamItem& item = out_.slot();
  item.camera = camera;
  item.number = image_count_++;
  item.sequence = sequence;
  latency_.add(HostClock::now() - read_at_);
  push_item(StreamItem::Kind::kImage, stamp);
}

void Intake::push_tick(Stamp stamp) {
  push_samples();
  for (size_t i = 0; i < datagrams_.size(); ++i) push_datagrams(LidarIndex(i));
  StreamItem& item = out_.slot();
  for (size_t i = 0; i < lidars_.size(); ++i) {
    LidarCounters& counters = item.counters.lidars[i];
    counters = lidars_[i].counters();
    counters.unclaimed = unclaimed_;
    if (counters.malformed + counters.wrong_sender > 0) continue;
    counters.unexpected_sender = unexpected_sender_;
    counters.unexpected_size = unexpected_size_;
  }
  for (size_t i = 0; i < cameras_.size(); ++i) {
    item.counters.cameras[i] = cameras_[i].counters();
  }
  vehicle_.write_counters(item.counters);
  sources_.write(item.counters);
  item.intake = latency_.stats();
  push_item(StreamItem::Kind::kTick, stamp);
}

void Intake::push_item(StreamItem::Kind kind, Stamp stamp) {
  StreamItem& item = out_.slot();
  item.kind = kind;
  item.stamp = stamp;
  item.read_at = read_at_;
  deliver(out_, delivery_, item.is_control());
}

}  // namespace infuse::daemon
