#include "daemon/pipeline/fusion_thread.hpp"

#include "daemon/pipeline/sweep_summary.hpp"

namespace infuse::daemon {
namespace {

constexpr Duration kImageTimeout{50'000'000};   // live
constexpr Duration kPoseInterval{100'000'000};  // between poses where there is no lidar
constexpr Duration kMaxClockStepBack{
    1'000'000'000};  // back by more than this, drive time begins anew

size_t index_of_lidar(const Rig& rig, const std::string& name) {
  size_t index = 0;
  while (index < rig.lidars.size() && rig.lidars[index].name != name) ++index;
  return index;
}

}  // namespace

FusionThread::FusionThread(const FusionSetup& setup, SlotRing<StreamItem>& in,
                           SlotRing<CameraImage>& images, SlotRing<ReportItem>& out,
                           Notifier& notifier)
    : setup_(setup),
      stream_(in),
      in_(in.make_reader()),
      out_(out),
      notifier_(notifier),
      odometry_(setup.odometry),
      sweeps_(max_pins(setup.rig.lidars.size()) - 2,
              setup.has_odometry ? setup.odometry.max_wait : Duration::zero()),
      images_(images, images.capacity(),
              setup.delivery == Delivery::kWait ? EventCount::kNoTimeout : kImageTimeout),
      unreadable_images_(setup.rig.cameras.size()),
      dropped_images_(setup.rig.cameras.size()),
      used_images_(setup.rig.cameras.size()) {
  if (setup.map != nullptr && !setup.map->empty() && setup.has_odometry) {
    map_tracker_.emplace(setup.streetmap, *setup.map, setup.rig);
  }
  for (const LidarMount& lidar : setup.rig.lidars) {
    deskewers_.emplace_back(lidar.T_vehicle_lidar);
  }
  for (const CameraMount& camera : setup.rig.cameras) {
    lidar_of_camera_.push_back(index_of_lidar(setup.rig, camera.lidar));
    cameras_.emplace_back(camera, setup.rig.lidars[lidar_of_camera_.back()].T_vehicle_lidar,
                          setup.calibration, setup.delivery == Delivery::kWait);
  }
}

void FusionThread::run() {
  bool ended = false;
  while (!ended && in_.wait()) {
    Pin<StreamItem> item = in_.next();
    if (!item) continue;
    ended = item->kind == StreamItem::Kind::kEnd;
    process(std::move(item));
  }
}

void FusionThread::process(Pin<StreamItem> item) {
  if (item->stamp > now_ || item->stamp + kMaxClockStepBack < now_) now_ = item->stamp;
  switch (item->kind) {
    case StreamItem::Kind::kStart:
      begin_report(ReportItem::Kind::kStart, item->stamp);
      return send_report();
    case StreamItem::Kind::kSamples:
      for (const VehicleSample& sample : item->samples) {
        odometry_.add(sample);
        const auto* fix = std::get_if<GnssFix>(&sample);
        if (map_tracker_ && fix != nullptr) map_tracker_->add_gnss(*fix);
      }
      if (setup_.rig.lidars.empty()) report_latest_pose();
      return process_due_sweeps();
    case StreamItem::Kind::kImage:
      if (const auto camera = images_.push(*item)) ++dropped_images_[*camera];
      return process_due_sweeps();
    case StreamItem::Kind::kSweep:
      now_ = std::max(now_, item->stamp + item->sweep.span);
      sweeps_.push(std::move(item));
      return process_due_sweeps();
    case StreamItem::Kind::kTick:
      process_due_sweeps();
      return report_tick(*item);
    case StreamItem::Kind::kFlush:
      odometry_.finish();
      while (!sweeps_.empty()) process_sweep(*sweeps_.pop());
      return;
    case StreamItem::Kind::kEnd:
      begin_report(ReportItem::Kind::kEnd, item->stamp);
      return send_report();
  }
}

void FusionThread::process_due_sweeps() {
  while (sweeps_.has_due(odometry_.trajectory(), now_)) process_sweep(*sweeps_.pop());
}

void FusionThread::process_sweep(const StreamItem& item) {
  report_sweep(item);
  if (setup_.has_odometry) report_pose(item.sweep.stamp + item.sweep.span);
  track_sweep(item);
  process_images(item);
  const Duration total = HostClock::now() - item.read_at;
  latency(Stage::kTotal).add(total);
  if (total > kLatencyBudget) ++deadline_misses_;
}

// As of the sweep's end, where the vehicle is now.
void FusionThread::report_sweep(const StreamItem& item) {
  const HostClock::time_point begin = HostClock::now();
  const Sweep& sweep = item.sweep;
  deskewers_[item.device].deskew(sweep, odometry_.trajectory(), sweep.stamp + sweep.span,
                                 deskewed_);
  ReportItem& report = begin_report(ReportItem::Kind::kSweep, sweep.stamp);
  report.sweep = summarise(sweep, item.device);
  report.sweep.deskew_reason =
      setup_.has_odometry ? deskewed_.reason : "nothing says how the vehicle moves";
  report.sweep.travelled = deskewed_.motion.T_from_to.translation().norm();
  report.sweep.turned = Eigen::AngleAxisd(deskewed_.motion.T_from_to.linear()).angle();
  if (setup_.has_odometry && !deskewed_.usable()) ++not_deskewed_;
  latency(Stage::kDeskew).add(HostClock::now() - begin);
  send_report();
}

void FusionThread::report_pose(Stamp stamp) {
  begin_report(ReportItem::Kind::kPose, stamp).pose = odometry_.pose_at(stamp);
  send_report();
}

// On the street map, as of the sweep's end.
void FusionThread::track_sweep(const StreamItem& item) {
  if (!map_tracker_) return;
  const HostClock::time_point begin = HostClock::now();
  const Stamp end = item.sweep.stamp + item.sweep.span;
  map_tracker_->add_sweep(item.sweep, deskewed_, item.device, odometry_.trajectory());
  latency(Stage::kTrack).add(HostClock::now() - begin);
  begin_report(ReportItem::Kind::kPose, end).pose = map_tracker_->pose(odometry_.pose_at(end));
  send_report();
}

// Where no lidar sets the pace: ten times a second, of what the filter has worked off.
void FusionThread::report_latest_pose() {
  const geometry::Trajectory& trajectory = odometry_.trajectory();
  if (trajectory.empty()) return;
  const Stamp newest = trajectory[trajectory.size() - 1].stamp;
  if (newest - last_pose_ < kPoseInterval && newest >= last_pose_) return;
  last_pose_ = newest;
  report_pose(newest);
}

// The pictures that were exposed before the sweep's end and not yet seen by an earlier sweep.
void FusionThread::process_images(const StreamItem& item) {
  const Stamp end = item.sweep.stamp + item.sweep.span;
  images_.pop_due(
      [&](uint32_t camera, Stamp exposure) {
        return lidar_of_camera_[camera] == item.device && exposure <= end;
      },
      [&](const CameraImage& image) { report_frame(image, item.sweep); });
}

void FusionThread::report_frame(const CameraImage& image, const Sweep& sweep) {
  latency(Stage::kDecode).add(image.decode_time);
  if (!image.readable) {
    ++unreadable_images_[image.camera];
    return;
  }
  const HostClock::time_point begin = HostClock::now();
  ++used_images_[image.camera];
  const FrameReport frame = cameras_[image.camera].project(image, sweep, odometry_.trajectory());
  begin_report(ReportItem::Kind::kFrame, image.stamp).frame = frame;
  latency(Stage::kProject).add(HostClock::now() - begin);
  send_report();
  if (*frame.reason == '\0') track_image(image, sweep);
  monitor_calibration(image, sweep);
}

void FusionThread::track_image(const CameraImage& image, const Sweep& sweep) {
  if (!map_tracker_) return;
  const HostClock::time_point begin = HostClock::now();
  map_tracker_->add_image(image.frame, image.stamp, image.camera, lidar_of_camera_[image.camera],
                          sweep, cameras_[image.camera].deskewed(), odometry_.trajectory());
  latency(Stage::kTrack).add(HostClock::now() - begin);
}

void FusionThread::monitor_calibration(const CameraImage& image, const Sweep& sweep) {
  const HostClock::time_point begin = HostClock::now();
  requests_.drain([&](const Request& request) { handle_request(request); });
  const CalibrationReport* calibration =
      cameras_[image.camera].monitor(image, sweep, odometry_.trajectory());
  latency(Stage::kMonitor).add(HostClock::now() - begin);
  if (calibration == nullptr) return;
  begin_report(ReportItem::Kind::kCalibration, image.stamp).calibration = *calibration;
  send_report();
}

void FusionThread::handle_request(const Request& request) {
  for (CameraChannel& camera : cameras_) {
    if (request.device.empty() || request.device == camera.name()) camera.handle_request(request);
  }
}

void FusionThread::report_tick(const StreamItem& item) {
  ReportItem& report = begin_report(ReportItem::Kind::kTick, item.stamp);
  report.counters = item.counters;  // of equal length: no allocation
  report.streams = item.streams;
  for (size_t camera = 0; camera < cameras_.size(); ++camera) {  // streams begin with the cameras
    report.streams[camera].used = used_images_[camera];
    report.streams[camera].refused += unreadable_images_[camera];
    report.streams[camera].lost += dropped_images_[camera];
  }
  report.odometry = odometry_.status(item.stamp);
  report.odometry.not_deskewed = not_deskewed_;
  if (map_tracker_) report.streetmap = map_tracker_->status();
  for (size_t i = 0; i < latencies_.size(); ++i) report.stages[i] = latencies_[i].stats();
  report.stages[static_cast<size_t>(Stage::kIntake)] = item.intake;
  report.deadline_misses = deadline_misses_;
  report.items_waiting = {"items", static_cast<uint32_t>(in_.backlog()),
                          static_cast<uint32_t>(stream_.capacity()), in_.lost()};
  send_report();
}

ReportItem& FusionThread::begin_report(ReportItem::Kind kind, Stamp stamp) {
  ReportItem& report = out_.slot();
  report.kind = kind;
  report.stamp = stamp;
  return report;
}

void FusionThread::send_report() {
  deliver(out_, setup_.delivery);
  notifier_.notify();
}

}  // namespace infuse::daemon
