#include "daemon/pipeline/fusion_stage.hpp"

#include "daemon/pipeline/sweep_summary.hpp"

namespace infuse::daemon {
namespace {

constexpr Duration kPicturePatience{50'000'000};  // live
constexpr Duration kPoseInterval{100'000'000};    // between poses where there is no lidar
constexpr Duration kClockStep{1'000'000'000};     // back by more than this, drive time begins anew

size_t index_of_lidar(const Rig& rig, const std::string& name) {
  size_t index = 0;
  while (index < rig.lidars.size() && rig.lidars[index].name != name) ++index;
  return index;
}

}  // namespace

FusionStage::FusionStage(const FusionSetup& setup, SlotRing<StreamItem>& in,
                         SlotRing<Picture>& pictures, SlotRing<ReportItem>& out, Doorbell& bell)
    : setup_(setup),
      stream_(in),
      in_(in.reader()),
      out_(out),
      bell_(bell),
      odometry_(setup.odometry),
      sweeps_(pins(setup.rig.lidars.size()) - 2,
              setup.has_odometry ? setup.odometry.max_wait : Duration::zero()),
      pictures_(pictures, pictures.capacity(),
                setup.delivery == Delivery::kWait ? Signal::kForever : kPicturePatience),
      unreadable_(setup.rig.cameras.size()),
      given_up_(setup.rig.cameras.size()),
      looked_at_(setup.rig.cameras.size()) {
  if (setup.map != nullptr && !setup.map->empty() && setup.has_odometry) {
    tracking_.emplace(setup.streetmap, *setup.map, setup.rig);
  }
  for (const LidarMount& lidar : setup.rig.lidars) {
    compensators_.emplace_back(lidar.T_vehicle_lidar);
  }
  for (const CameraMount& camera : setup.rig.cameras) {
    lidar_of_camera_.push_back(index_of_lidar(setup.rig, camera.lidar));
    cameras_.emplace_back(camera, setup.rig.lidars[lidar_of_camera_.back()].T_vehicle_lidar,
                          setup.calibration, setup.delivery == Delivery::kWait);
  }
}

void FusionStage::run() {
  bool ended = false;
  while (!ended && in_.wait()) {
    Pin<StreamItem> item = in_.next();
    if (!item) continue;
    ended = item->kind == StreamItem::Kind::kEnd;
    take(std::move(item));
  }
}

void FusionStage::take(Pin<StreamItem> item) {
  if (item->stamp > now_ || item->stamp + kClockStep < now_) now_ = item->stamp;
  switch (item->kind) {
    case StreamItem::Kind::kStart:
      begin_report(ReportItem::Kind::kStart, item->stamp);
      return send_report();
    case StreamItem::Kind::kSamples:
      for (const VehicleSample& sample : item->samples) {
        odometry_.take(sample);
        const auto* fix = std::get_if<GpsFix>(&sample);
        if (tracking_ && fix != nullptr) tracking_->take(*fix);
      }
      if (setup_.rig.lidars.empty()) tell_pose_now();
      return take_due_sweeps();
    case StreamItem::Kind::kPicture:
      if (const auto camera = pictures_.expect(*item)) ++given_up_[*camera];
      return take_due_sweeps();
    case StreamItem::Kind::kSweep:
      now_ = std::max(now_, item->stamp + item->sweep.span);
      sweeps_.push(std::move(item));
      return take_due_sweeps();
    case StreamItem::Kind::kTick:
      take_due_sweeps();
      return tell_tick(*item);
    case StreamItem::Kind::kLast:
      odometry_.finish();
      while (!sweeps_.empty()) take_sweep(*sweeps_.pop());
      return;
    case StreamItem::Kind::kEnd:
      begin_report(ReportItem::Kind::kEnd, item->stamp);
      return send_report();
  }
}

void FusionStage::take_due_sweeps() {
  while (sweeps_.due(odometry_.trajectory(), now_)) take_sweep(*sweeps_.pop());
}

void FusionStage::take_sweep(const StreamItem& item) {
  tell_sweep(item);
  if (setup_.has_odometry) tell_pose(item.sweep.stamp + item.sweep.span);
  track_sweep(item);
  look_at_pictures(item);
  const Duration whole = HostClock::now() - item.taken;
  latency(Stage::kWhole).add(whole);
  if (whole > kBudget) ++deadline_misses_;
}

// As of the sweep's end, where the vehicle is now.
void FusionStage::tell_sweep(const StreamItem& item) {
  const HostClock::time_point begin = HostClock::now();
  const Sweep& sweep = item.sweep;
  compensators_[item.device].compensate(sweep, odometry_.trajectory(), sweep.stamp + sweep.span,
                                        straight_);
  ReportItem& report = begin_report(ReportItem::Kind::kSweep, sweep.stamp);
  report.sweep = summarise(sweep, item.device);
  report.sweep.straight_reason =
      setup_.has_odometry ? straight_.reason : "nothing says how the vehicle moves";
  report.sweep.travelled = straight_.motion.T_from_to.translation().norm();
  report.sweep.turned = Eigen::AngleAxisd(straight_.motion.T_from_to.linear()).angle();
  if (setup_.has_odometry && !straight_.usable()) ++uncompensated_;
  latency(Stage::kStraight).add(HostClock::now() - begin);
  send_report();
}

void FusionStage::tell_pose(Stamp stamp) {
  begin_report(ReportItem::Kind::kPose, stamp).pose = odometry_.pose_at(stamp);
  send_report();
}

// On the street map, as of the sweep's end.
void FusionStage::track_sweep(const StreamItem& item) {
  if (!tracking_) return;
  const HostClock::time_point begin = HostClock::now();
  const Stamp end = item.sweep.stamp + item.sweep.span;
  tracking_->take_sweep(item.sweep, straight_, item.device, odometry_.trajectory());
  latency(Stage::kTrack).add(HostClock::now() - begin);
  begin_report(ReportItem::Kind::kPose, end).pose = tracking_->pose(odometry_.pose_at(end));
  send_report();
}

// Where no lidar sets the pace: ten times a second, of what the filter has worked off.
void FusionStage::tell_pose_now() {
  const geometry::Trajectory& trajectory = odometry_.trajectory();
  if (trajectory.empty()) return;
  const Stamp newest = trajectory[trajectory.size() - 1].stamp;
  if (newest - last_pose_ < kPoseInterval && newest >= last_pose_) return;
  last_pose_ = newest;
  tell_pose(newest);
}

// The pictures that were exposed before the sweep's end and not yet seen by an earlier sweep.
void FusionStage::look_at_pictures(const StreamItem& item) {
  const Stamp end = item.sweep.stamp + item.sweep.span;
  pictures_.take(
      [&](uint32_t camera, Stamp exposure) {
        return lidar_of_camera_[camera] == item.device && exposure <= end;
      },
      [&](const Picture& picture) { tell_frame(picture, item.sweep); });
}

void FusionStage::tell_frame(const Picture& picture, const Sweep& sweep) {
  latency(Stage::kDecode).add(picture.decoding);
  if (!picture.readable) {
    ++unreadable_[picture.camera];
    return;
  }
  const HostClock::time_point begin = HostClock::now();
  ++looked_at_[picture.camera];
  const FrameReport frame = cameras_[picture.camera].look(picture, sweep, odometry_.trajectory());
  begin_report(ReportItem::Kind::kFrame, picture.stamp).frame = frame;
  latency(Stage::kProject).add(HostClock::now() - begin);
  send_report();
  if (*frame.reason == '\0') track_picture(picture, sweep);
  watch_calibration(picture, sweep);
}

void FusionStage::track_picture(const Picture& picture, const Sweep& sweep) {
  if (!tracking_) return;
  const HostClock::time_point begin = HostClock::now();
  tracking_->take_picture(picture.frame, picture.stamp, picture.camera,
                          lidar_of_camera_[picture.camera], sweep,
                          cameras_[picture.camera].straight(), odometry_.trajectory());
  latency(Stage::kTrack).add(HostClock::now() - begin);
}

void FusionStage::watch_calibration(const Picture& picture, const Sweep& sweep) {
  const HostClock::time_point begin = HostClock::now();
  asked_.take([&](const Request& request) { obey(request); });
  const CalibrationReport* calibration =
      cameras_[picture.camera].watch(picture, sweep, odometry_.trajectory());
  latency(Stage::kWatch).add(HostClock::now() - begin);
  if (calibration == nullptr) return;
  begin_report(ReportItem::Kind::kCalibration, picture.stamp).calibration = *calibration;
  send_report();
}

void FusionStage::obey(const Request& request) {
  for (CameraStage& camera : cameras_) {
    if (request.device.empty() || request.device == camera.name()) camera.obey(request);
  }
}

void FusionStage::tell_tick(const StreamItem& item) {
  ReportItem& report = begin_report(ReportItem::Kind::kTick, item.stamp);
  report.counters = item.counters;  // of equal length: no allocation
  report.streams = item.streams;
  for (size_t camera = 0; camera < cameras_.size(); ++camera) {  // streams begin with the cameras
    report.streams[camera].used = looked_at_[camera];
    report.streams[camera].refused += unreadable_[camera];
    report.streams[camera].lost += given_up_[camera];
  }
  report.odometry = odometry_.figures(item.stamp);
  report.odometry.uncompensated = uncompensated_;
  if (tracking_) report.streetmap = tracking_->figures();
  for (size_t i = 0; i < latencies_.size(); ++i) report.stages[i] = latencies_[i].figures();
  report.stages[static_cast<size_t>(Stage::kIntake)] = item.intake;
  report.deadline_misses = deadline_misses_;
  report.items_waiting = {"items", static_cast<uint32_t>(in_.behind()),
                          static_cast<uint32_t>(stream_.capacity()), in_.lost()};
  send_report();
}

ReportItem& FusionStage::begin_report(ReportItem::Kind kind, Stamp stamp) {
  ReportItem& report = out_.hand();
  report.kind = kind;
  report.stamp = stamp;
  return report;
}

void FusionStage::send_report() {
  deliver(out_, setup_.delivery);
  bell_.ring();
}

}  // namespace infuse::daemon
