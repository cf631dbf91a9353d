#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>

#include "daemon/health/latency_histogram.hpp"
#include "daemon/pipeline/camera_channel.hpp"
#include "daemon/pipeline/control_queue.hpp"
#include "daemon/pipeline/delivery.hpp"
#include "daemon/pipeline/image_queue.hpp"
#include "daemon/pipeline/map_tracker.hpp"
#include "daemon/pipeline/notifier.hpp"
#include "daemon/pipeline/odometry_tracker.hpp"
#include "daemon/pipeline/report_item.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "daemon/pipeline/sweep_queue.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/slot_ring.hpp"
#include "fusion/motion/deskew.hpp"

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
class FusionThread {
 public:
  /// From the reading of the packet that completed a sweep to its report, at most, host time.
  static constexpr Duration kLatencyBudget{100'000'000};
  /// Pins that the stage holds at most on the ring of items; the ring has more room than this.
  static size_t max_pins(size_t lidars) { return 2 * lidars + 2; }

  /// Registers as a reader of `in` and of `pictures`. The rings and the bell outlive this.
  FusionThread(const FusionSetup& setup, SlotRing<StreamItem>& in, SlotRing<CameraImage>& images,
               SlotRing<ReportItem>& out, Notifier& bell);

  /// Until the item kEnd has been passed on.
  void run();

  /// What the owner asks of the cameras' calibrations; from any thread.
  void post_request(const Request& request) { requests_.push(request); }

  /// Nothing is waited for that only the background can bring, from now on; from any thread.
  void shut_down() {
    for (CameraChannel& camera : cameras_) camera.shut_down();
  }

 private:
  void process(Pin<StreamItem> item);
  void process_due_sweeps();
  void process_sweep(const StreamItem& item);
  void report_sweep(const StreamItem& item);
  void report_pose(Stamp stamp);
  void track_sweep(const StreamItem& item);
  void track_image(const CameraImage& image, const Sweep& sweep);
  void report_latest_pose();
  void process_images(const StreamItem& item);
  void report_frame(const CameraImage& image, const Sweep& sweep);
  void monitor_calibration(const CameraImage& image, const Sweep& sweep);
  void handle_request(const Request& request);
  void report_tick(const StreamItem& item);
  ReportItem& begin_report(ReportItem::Kind kind, Stamp stamp);
  void send_report();
  LatencyHistogram& latency(Stage stage) { return latencies_[static_cast<size_t>(stage)]; }

  FusionSetup setup_;
  SlotRing<StreamItem>& stream_;
  SlotRing<StreamItem>::Reader in_;
  SlotRing<ReportItem>& out_;
  Notifier& notifier_;

  OdometryTracker odometry_;
  SweepQueue sweeps_;
  ImageQueue images_;
  std::optional<MapTracker> map_tracker_;
  std::deque<motion::Deskewer> deskewers_;  // by lidar
  std::deque<CameraChannel> cameras_;       // by camera
  std::vector<size_t> lidar_of_camera_;
  motion::DeskewedSweep deskewed_;
  ControlQueue requests_;

  Stamp now_ = Stamp::earliest();        // drive time
  Stamp last_pose_ = Stamp::earliest();  // told without a sweep
  uint64_t not_deskewed_ = 0;
  std::vector<uint64_t> unreadable_images_;  // pictures, by camera
  std::vector<uint64_t> dropped_images_;     // pictures that no sweep came for, by camera
  std::vector<uint64_t> used_images_;        // pictures, by camera
  std::array<LatencyHistogram, static_cast<size_t>(Stage::kCount)> latencies_;
  uint64_t deadline_misses_ = 0;
};

}  // namespace infuse::daemon
