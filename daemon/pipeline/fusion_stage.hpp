#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>

#include "daemon/health/latency_histogram.hpp"
#include "daemon/pipeline/camera_stage.hpp"
#include "daemon/pipeline/control_queue.hpp"
#include "daemon/pipeline/delivery.hpp"
#include "daemon/pipeline/doorbell.hpp"
#include "daemon/pipeline/odometry_stage.hpp"
#include "daemon/pipeline/picture_queue.hpp"
#include "daemon/pipeline/report_item.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "daemon/pipeline/sweep_queue.hpp"
#include "daemon/pipeline/tracking_stage.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/slot_ring.hpp"
#include "fusion/motion/compensation.hpp"

namespace infuse::daemon {

/// What the fusion thread works with.
struct FusionSetup {
  Rig rig;
  bool has_odometry = false;  ///< something says how the vehicle moves
  OdometrySettings odometry;
  CalibrationSettings calibration;
  Delivery delivery = Delivery::kWait;
  StreetMapSettings streetmap;
  const streetmap::SegmentMap* map = nullptr;  ///< null or empty: the vehicle is not tracked
};

/// The fusion thread: takes what the io thread hands over, in order, and makes reports of it. A
/// sweep waits until odometry covers its time, is made straight, and told; the pictures that were
/// exposed meanwhile meet it as it was at their moment. In a replay it waits for whoever tells the
/// reports, and drops none.
class FusionStage {
 public:
  /// From the reading of the packet that completed a sweep to its report, at most, host time.
  static constexpr Duration kBudget{100'000'000};
  /// Pins that the stage holds at most on the ring of items; the ring has more room than this.
  static size_t pins(size_t lidars) { return 2 * lidars + 2; }

  /// Registers as a reader of `in` and of `pictures`. The rings and the bell outlive this.
  FusionStage(const FusionSetup& setup, SlotRing<StreamItem>& in, SlotRing<Picture>& pictures,
              SlotRing<ReportItem>& out, Doorbell& bell);

  /// Until the item kEnd has been passed on.
  void run();

  /// What the owner asks of the cameras' calibrations; from any thread.
  void ask(const Request& request) { asked_.push(request); }

  /// Nothing is waited for that only the background can bring, from now on; from any thread.
  void shut_down() {
    for (CameraStage& camera : cameras_) camera.shut_down();
  }

 private:
  void take(Pin<StreamItem> item);
  void take_due_sweeps();
  void take_sweep(const StreamItem& item);
  void tell_sweep(const StreamItem& item);
  void tell_pose(Stamp stamp);
  void track_sweep(const StreamItem& item);
  void track_picture(const Picture& picture, const Sweep& sweep);
  void tell_pose_now();
  void look_at_pictures(const StreamItem& item);
  void tell_frame(const Picture& picture, const Sweep& sweep);
  void watch_calibration(const Picture& picture, const Sweep& sweep);
  void obey(const Request& request);
  void tell_tick(const StreamItem& item);
  ReportItem& begin_report(ReportItem::Kind kind, Stamp stamp);
  void send_report();
  LatencyHistogram& latency(Stage stage) { return latencies_[static_cast<size_t>(stage)]; }

  FusionSetup setup_;
  SlotRing<StreamItem>& stream_;
  SlotRing<StreamItem>::Reader in_;
  SlotRing<ReportItem>& out_;
  Doorbell& bell_;

  OdometryStage odometry_;
  SweepQueue sweeps_;
  PictureQueue pictures_;
  std::optional<TrackingStage> tracking_;
  std::deque<motion::MotionCompensator> compensators_;  // by lidar
  std::deque<CameraStage> cameras_;                     // by camera
  std::vector<size_t> lidar_of_camera_;
  motion::StraightSweep straight_;
  ControlQueue asked_;

  Stamp now_ = Stamp::earliest();        // drive time
  Stamp last_pose_ = Stamp::earliest();  // told without a sweep
  uint64_t uncompensated_ = 0;
  std::vector<uint64_t> unreadable_;  // pictures, by camera
  std::vector<uint64_t> given_up_;    // pictures that no sweep came for, by camera
  std::vector<uint64_t> looked_at_;   // pictures, by camera
  std::array<LatencyHistogram, static_cast<size_t>(Stage::kCount)> latencies_;
  uint64_t deadline_misses_ = 0;
};

}  // namespace infuse::daemon
