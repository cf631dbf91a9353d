#include "daemon/pipeline/fusion_thread.hpp"

#include "daemon/pipeline/pairing.hpp"
#include "daemon/pipeline/sweep_summary.hpp"

namespace infuse::daemon {
namespace {

constexpr Duration kImageTimeout{50'000'000};         // live
constexpr Duration kPoseInterval{100'000'000};        // without a lidar
constexpr Duration kMaxClockStepBack{1'000'000'000};  // beyond it, drive time begins anew

/// Adds the host time of a scope to a histogram.
class ScopedLatency {
 public:
  explicit ScopedLatency(LatencyHistogram& latency) : latency_(latency) {}
  ~ScopedLatency() { latency_.add(HostClock::now() - begin_); }
  ScopedLatency(const ScopedLatency&) = delete;
  ScopedLatency& operator=(const ScopedLatency&) = delete;

 private:
  LatencyHistogram& latency_;
  HostClock::time_point begin_ = HostClock::now();
};

LidarIndex index_of_lidar(const Rig& rig, const std::string& name) {
  size_t index = 0;
  while (index < rig.lidars.size() && rig.lidars[index].name != name) ++index;
  return LidarIndex(index);
}

/// Mounting of the lidar that measures motion.
Eigen::Isometry3d first_mounting(const Rig& rig) {
  return rig.lidars.empty() ? Eigen::Isometry3d::Identity() : rig.lidars[0].T_vehicle_lidar;
}

/// The cameras by index, each with its configured place.
std::vector<monitoring::PlacedCamera> placed_cameras(const Rig& rig) {
  std::vector<monitoring::PlacedCamera> placed;
  for (const CameraMount& camera : rig.cameras) {
    placed.push_back(
        {camera.name, camera.intrinsics, index_of_lidar(rig, camera.lidar), camera.T_camera_lidar});
  }
  return placed;
}

Stamp end_of(const Sweep& sweep) { return sweep.stamp + sweep.span; }

}  // namespace

FusionThread::FusionThread(const FusionSetup& setup, SlotRing<StreamItem>& in,
                           SlotRing<CameraImage>& images, SlotRing<ReportItem>& out,
                           Notifier& notifier)
    : setup_(setup),
      stream_(in),
      in_(in.make_reader()),
      out_(out),
      notifier_(notifier),
      odometry_(setup.odometry, first_mounting(setup.rig)),
      sweeps_(max_waiting_sweeps(setup.rig.lidars.size()),
              setup.has_motion_sensor ? setup.odometry.max_wait : Duration::zero()),
      previous_sweeps_(setup.rig.lidars.size()),
      images_(images, images.capacity(),
              setup.delivery == Delivery::kWait ? EventCount::kNoTimeout : kImageTimeout),
      places_lidar_(setup.places_lidar.empty() ? LidarIndex(0)
                                               : index_of_lidar(setup.rig, setup.places_lidar)),
      assignment_(placed_cameras(setup.rig), setup.calibration.monitor.detector,
                  setup.calibration.monitor.weights, setup.calibration.monitor.max_points),
      dropped_sweeps_(setup.rig.lidars.size()),
      image_counters_(setup.rig.cameras.size()) {
  maps_ = std::move(*make_map_tasks(std::move(setup_.maps)));
  // A map that takes the place of these begins where the vehicle is, not where it started.
  setup_.streetmap.initial_pose.reset();
  setup_.streetmap.initial_location.reset();
  const bool checks_rest =
      setup.has_odometry && !setup.rig.lidars.empty() && setup.rig.lidars[0].is_mounting_known();
  if (odometry_.uses_lidar() || checks_rest) {
    lidar_motion_.emplace(setup.rig.lidars[0].T_vehicle_lidar);
  }
  for (const LidarMount& lidar : setup.rig.lidars) {
    deskewers_.emplace_back(lidar.T_vehicle_lidar);
  }
  for (const CameraMount& camera : setup.rig.cameras) {
    const LidarIndex lidar = index_of_lidar(setup.rig, camera.lidar);
    cameras_.emplace_back(camera, lidar, setup.rig.lidars[lidar].T_vehicle_lidar, setup.calibration,
                          setup.delivery == Delivery::kWait);
  }
  for (size_t k = 0; k < cameras_.size(); ++k) {
    if (CalibrationGuard* guard = cameras_[k].guard()) guard->set_assignment(assignment_, k);
  }
}

std::shared_ptr<MapTasks> FusionThread::make_map_tasks(Maps maps) const {
  auto tasks = std::make_shared<MapTasks>();
  if (!setup_.has_odometry) return tasks;
  if (!maps.street_map.map.empty()) {
    tasks->street_map = std::make_unique<StreetMapTracker>(setup_.streetmap,
                                                           std::move(maps.street_map), setup_.rig);
  }
  if (maps.places && !setup_.rig.lidars.empty()) {
    tasks->places = std::make_unique<MapLocaliser>(*std::move(maps.places),
                                                   setup_.rig.lidars[places_lidar_].T_vehicle_lidar,
                                                   setup_.delivery == Delivery::kWait);
  }
  return tasks;
}

void FusionThread::shut_down() {
  for (CameraChannel& camera : cameras_) camera.shut_down();
  const std::lock_guard lock(maps_mutex_);
  shut_down_ = true;
  if (maps_.places) maps_.places->shut_down();
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
  if (item->kind == StreamItem::Kind::kDatagrams) return;  // they do not advance drive time
  if (item->stamp > now_ || item->stamp + kMaxClockStepBack < now_) now_ = item->stamp;
  read_at_ = item->read_at;
  behind_ = HostClock::now() - read_at_;
  commands_.drain(
      [&](const auto& command) { std::visit([&](const auto& what) { handle(what); }, command); });
  switch (item->kind) {
    case StreamItem::Kind::kStart:
      begin_report(ReportItem::Kind::kStart, item->stamp);
      return send_report();
    case StreamItem::Kind::kSamples:
      process_samples(*item);
      return process_due_sweeps();
    case StreamItem::Kind::kImage:
      if (const auto camera = images_.push(*item)) ++image_counters_[*camera].dropped;
      return process_due_sweeps();
    case StreamItem::Kind::kSweep:
      now_ = std::max(now_, end_of(item->sweep));
      if (is_behind(kMaxLateness)) {
        ++dropped_sweeps_[item->lidar];
        return process_due_sweeps();
      }
      odometry_.mark(end_of(item->sweep), measures_motion(item->lidar));
      sweeps_.push(std::move(item));
      return process_due_sweeps();
    case StreamItem::Kind::kTick:
      process_due_sweeps();
      if (setup_.tap != nullptr) setup_.tap->end_second();
      for (CameraChannel& camera : cameras_) {
        if (camera.guard() != nullptr) report(camera.guard()->report_if_due(item->stamp));
      }
      return report_tick(*item);
    case StreamItem::Kind::kDatagrams:
      return;
    case StreamItem::Kind::kFlush:
      odometry_.finish();
      while (!sweeps_.empty()) process_sweep(sweeps_.pop());
      process_last_images();
      for (CameraChannel& camera : cameras_) {
        if (camera.guard() != nullptr) report(camera.guard()->report_at_end(item->stamp));
      }
      return;
    case StreamItem::Kind::kEnd:
      begin_report(ReportItem::Kind::kEnd, item->stamp);
      return send_report();
  }
}

void FusionThread::process_samples(const StreamItem& item) {
  for (const VehicleSample& sample : item.samples) {
    odometry_.add(sample);
    const auto* fix = std::get_if<GnssFix>(&sample);
    if (maps_.street_map && fix != nullptr) maps_.street_map->add_gnss(*fix);
  }
  if (setup_.rig.lidars.empty()) report_latest_pose();
}

void FusionThread::process_due_sweeps() {
  while (sweeps_.has_due(odometry_.trajectory(), now_)) process_sweep(sweeps_.pop());
}

// The images are those that were exposed before the sweep's end and not matched with an earlier
// one. An image between two sweeps is matched with the nearer one.
void FusionThread::process_sweep(Pin<StreamItem> item) {
  odometry_.process_until(end_of(item->sweep));
  const bool measures = measures_motion(item->lidar);
  if (lidar_motion_ && item->lidar == LidarIndex(0) && !measures) lidar_motion_->restart();
  const SweepSnapshot snapshot = measures ? measure_motion(*item) : deskew(*item);
  report_sweep(snapshot);
  localise(snapshot);
  show(snapshot);
  images_.pop_due(
      [&](CameraIndex camera, Stamp exposure) {
        return cameras_[camera].lidar() == item->lidar && is_before_end(exposure, item->sweep);
      },
      [&](const CameraImage& image) { process_image(image, nearest_sweep(image.stamp, *item)); });
  const Duration total = HostClock::now() - read_at_;
  latency(Stage::kTotal).add(total);
  if (total > kLatencyBudget) ++deadline_misses_;
  const LidarIndex lidar = item->lidar;
  previous_sweeps_[lidar] = std::move(item);
}

// Lateness is that of the item just read, so waiting for odometry does not count. A replay is never
// late.
bool FusionThread::is_behind(Duration lateness) const {
  return setup_.delivery == Delivery::kOverwrite && behind_ > lateness;
}

// Deskews the sweep by prediction, and again by what its registration measured.
SweepSnapshot FusionThread::measure_motion(const StreamItem& item) {
  const SweepSnapshot snapshot = deskew(item);
  if (is_behind(kLatencyBudget)) {
    ++skipped_registrations_;
    return snapshot;
  }
  const ScopedLatency timer(latency(Stage::kRegister));
  lidar_motion_->measure(item.sweep, odometry_, deskewers_[item.lidar], deskewed_,
                         [&] { deskew(item); });
  return snapshot;
}

const Sweep& FusionThread::nearest_sweep(Stamp exposure, const StreamItem& item) const {
  const Pin<StreamItem>& previous = previous_sweeps_[item.lidar];
  const bool earlier =
      previous && pairing_gap(exposure, previous->sweep) < pairing_gap(exposure, item.sweep);
  return earlier ? previous->sweep : item.sweep;
}

// No sweep follows: images after the last one are matched with it.
void FusionThread::process_last_images() {
  const auto last = [&](CameraIndex camera) -> const Pin<StreamItem>& {
    return previous_sweeps_[cameras_[camera].lidar()];
  };
  images_.pop_due(
      [&](CameraIndex camera, Stamp exposure) {
        return last(camera) && pairing_gap(exposure, last(camera)->sweep) <= kMaxPairingGap;
      },
      [&](const CameraImage& image) { process_image(image, last(image.camera)->sweep); });
}

// As of the sweep's end; without odometry, a sweep that its source has deskewed is used as it is.
SweepSnapshot FusionThread::deskew(const StreamItem& item) {
  const ScopedLatency timer(latency(Stage::kDeskew));
  const Sweep& sweep = item.sweep;
  const bool as_it_is = sweep.deskewed && !setup_.has_odometry;
  deskewers_[item.lidar].deskew(sweep, odometry_.trajectory(),
                                as_it_is ? sweep.stamp + sweep.span / 2 : end_of(sweep), deskewed_);
  return {item.lidar, sweep, deskewed_};
}

void FusionThread::report_sweep(const SweepSnapshot& snapshot) {
  const motion::DeskewedSweep& deskewed = snapshot.deskewed;
  SweepReport& report = begin_report(ReportItem::Kind::kSweep, snapshot.sweep.stamp).sweep;
  report = summarise(snapshot.sweep, setup_.rig.lidars[snapshot.lidar].name);
  const bool used = setup_.has_odometry || deskewed.usable();
  report.deskew_reason = used ? deskewed.reason : "no odometry";
  report.travelled = deskewed.motion.T_from_to.translation().norm();
  report.turned = Eigen::AngleAxisd(deskewed.motion.T_from_to.linear()).angle();
  if (setup_.has_odometry && !deskewed.usable()) ++not_deskewed_;
  send_report();
}

// Poses in the frames odom and map, as of the snapshot.
void FusionThread::localise(const SweepSnapshot& snapshot) {
  if (!setup_.has_odometry) return;
  const PoseReport odometry = odometry_.pose_at(snapshot.deskewed.reference);
  PoseReport published = odometry;
  odometry_.bound(published);
  report(published);
  if (maps_.places && snapshot.lidar == places_lidar_) {
    report(maps_.places->process(snapshot, odometry_.trajectory(), odometry));
  }
  if (!maps_.street_map) return;
  const auto track = [&] {
    const ScopedLatency timer(latency(Stage::kTrack));
    return maps_.street_map->process(snapshot, odometry_.trajectory(), odometry_.predicted_pose(),
                                     odometry);
  };
  report(track());
}

// To who looks; copies nothing while nobody does.
void FusionThread::show(const SweepSnapshot& snapshot) {
  if (setup_.tap != nullptr) setup_.tap->add_sweep(snapshot);
  if (setup_.view == nullptr || !setup_.view->wanted()) return;
  const PoseReport pose = odometry_.pose_at(snapshot.deskewed.reference);
  const bool located = setup_.has_odometry && pose.usable();
  const bool on_map = maps_.street_map && maps_.street_map->started();
  if (on_map) maps_.street_map->write(view_pose_);
  setup_.view->add_sweep(snapshot, located ? &pose.T_frame_vehicle : nullptr,
                         on_map ? &view_pose_ : nullptr);
}

void FusionThread::process_image(const CameraImage& image, const Sweep& sweep) {
  latency(Stage::kDecode).add(image.decode_time);
  ImageCounters& counters = image_counters_[image.camera];
  ++(image.readable ? counters.used : counters.unreadable);
  if (!image.readable) return;
  const auto project = [&] {
    const ScopedLatency timer(latency(Stage::kProject));
    return cameras_[image.camera].project(image, sweep, odometry_.trajectory());
  };
  const ImageMatch match = project();
  begin_report(ReportItem::Kind::kFrame, image.stamp).frame =
      summarise(match, cameras_[image.camera].name());
  send_report();
  if (!match.usable()) return;
  if (setup_.view != nullptr) {
    setup_.view->add_image(match, cameras_[image.camera].estimate());
  }
  if (maps_.street_map) {
    const ScopedLatency timer(latency(Stage::kTrack));
    maps_.street_map->add_image(match, odometry_.trajectory());
  }
  monitor_calibration(match);
}

void FusionThread::monitor_calibration(const ImageMatch& match) {
  const auto monitor = [&] {
    const ScopedLatency timer(latency(Stage::kMonitor));
    return cameras_[match.image.camera].monitor(match, odometry_.trajectory());
  };
  report(monitor());
}

/// Null: none is due.
void FusionThread::report(const CalibrationReport* calibration) {
  if (calibration == nullptr) return;
  begin_report(ReportItem::Kind::kCalibration, calibration->stamp).calibration = *calibration;
  send_report();
}

// Without a lidar: ten times a second, the latest pose of the filter.
void FusionThread::report_latest_pose() {
  const geometry::Trajectory& trajectory = odometry_.trajectory();
  if (trajectory.empty()) return;
  const Stamp newest = trajectory[trajectory.size() - 1].stamp;
  if (newest - last_pose_ < kPoseInterval && newest >= last_pose_) return;
  last_pose_ = newest;
  PoseReport published = odometry_.pose_at(newest);
  odometry_.bound(published);
  report(published);
}

void FusionThread::report_tick(const StreamItem& item) {
  ReportItem& report = begin_report(ReportItem::Kind::kTick, item.stamp);
  report.counters = item.counters;  // of one setup: no allocation
  for (size_t lidar = 0; lidar < dropped_sweeps_.size(); ++lidar) {
    report.counters.lidars[lidar].dropped_sweeps = dropped_sweeps_[lidar];
  }
  for (size_t camera = 0; camera < cameras_.size(); ++camera) {
    const ImageCounters& counters = image_counters_[camera];
    StreamCounters& reported = report.counters.cameras[camera];
    reported.used = counters.used;
    reported.refused += counters.unreadable;
    reported.lost += counters.dropped;
  }
  report.odometry = setup_.has_odometry ? odometry_.status(item.stamp) : OdometryStatus{};
  report.odometry.not_deskewed = not_deskewed_;
  if (maps_.street_map) report.streetmap = maps_.street_map->status();
  if (maps_.places) report.map = maps_.places->status();
  for (size_t i = 0; i < latencies_.size(); ++i) report.stages[i] = latencies_[i].stats();
  report.stages[static_cast<size_t>(Stage::kIntake)] = item.intake;
  report.deadline_misses = deadline_misses_;
  report.skipped_registrations = skipped_registrations_;
  report.items_waiting = {"items", static_cast<uint32_t>(in_.backlog()),
                          static_cast<uint32_t>(stream_.capacity()), in_.lost()};
  send_report();
}

void FusionThread::handle(const CalibrationCommand& command) {
  for (CameraChannel& camera : cameras_) {
    if (command.camera != camera.name() || camera.guard() == nullptr) continue;
    report(camera.guard()->handle(command, now_));
  }
}

void FusionThread::handle(const std::shared_ptr<MapTasks>& next) {
  const std::lock_guard lock(maps_mutex_);
  if (next->street_map) {
    if (maps_.street_map) next->street_map->go_on_from(*maps_.street_map);
    std::swap(maps_.street_map, next->street_map);
  }
  if (!next->places) return;
  std::swap(maps_.places, next->places);
  if (shut_down_ && maps_.places) maps_.places->shut_down();
  if (next->places) next->places->shut_down();  // who posted it waits for its end
}

void FusionThread::report(const PoseReport& pose) {
  begin_report(ReportItem::Kind::kPose, pose.stamp).pose = pose;
  send_report();
}

ReportItem& FusionThread::begin_report(ReportItem::Kind kind, Stamp stamp) {
  ReportItem& report = out_.slot();
  report.kind = kind;
  report.stamp = stamp;
  return report;
}

void FusionThread::send_report() {
  deliver(out_, setup_.delivery, out_.slot().is_control());
  notifier_.notify();
}

}  // namespace infuse::daemon
