#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <variant>

#include "daemon/health/latency_histogram.hpp"
#include "daemon/pipeline/camera_channel.hpp"
#include "daemon/pipeline/control_queue.hpp"
#include "daemon/pipeline/delivery.hpp"
#include "daemon/pipeline/image_queue.hpp"
#include "daemon/pipeline/lidar_motion.hpp"
#include "daemon/pipeline/map_tasks.hpp"
#include "daemon/pipeline/notifier.hpp"
#include "daemon/pipeline/odometry_tracker.hpp"
#include "daemon/pipeline/pipeline_tap.hpp"
#include "daemon/pipeline/report_item.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "daemon/pipeline/sweep_queue.hpp"
#include "daemon/pipeline/view_tap.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/slot_ring.hpp"
#include "fusion/motion/deskew.hpp"

namespace infuse::daemon {

/// Settings of the fusion thread.
struct FusionSetup {
  Rig rig;
  bool has_odometry = false;  ///< there is a source of odometry
  /// There is a bus, a speed sensor or an inertial unit: sweeps wait for its samples.
  bool has_motion_sensor = false;
  OdometrySettings odometry;
  CalibrationSettings calibration;
  Delivery delivery = Delivery::kWait;
  StreetMapSettings streetmap;
  Maps maps;
  std::string places_lidar;    ///< whose sweeps are compared with it; empty: the first
  ViewTap* view = nullptr;     ///< null: nobody can look
  PipelineTap* tap = nullptr;  ///< null: nobody wants copies
};

/// The fusion thread: processes the items of the io thread in order and publishes reports. A sweep
/// waits until the vehicle's sensors cover its time; without them its motion is predicted and, with
/// `use_lidar`, measured by registration. `process_sweep` is the whole processing of a sweep and
/// its images.
///
/// Live, an overloaded processor must not delay everything behind its sweeps: while this thread is
/// behind by more than `kLatencyBudget` sweeps are not registered, beyond `kMaxLateness` they are
/// dropped; both are counted.
class FusionThread {
 public:
  /// Maximum host time from the reading of the event that made a sweep due (its last packet, or the
  /// odometry it waited for) to its last report.
  static constexpr Duration kLatencyBudget{100'000'000};
  /// Maximum age of a sweep, live, at which it is still processed.
  static constexpr Duration kMaxLateness{1'000'000'000};
  /// Maximum number of sweeps that wait for odometry.
  static size_t max_waiting_sweeps(size_t lidars) { return 2 * lidars; }
  /// Maximum number of pins held on the ring of items, which must have more room: those sweeps, the
  /// last sweep of each lidar, the item in hand and one sweep beyond the limit.
  static size_t max_pins(size_t lidars) { return max_waiting_sweeps(lidars) + lidars + 2; }

  /// Registers as a reader of `in` and `images`. The rings and the notifier outlive this.
  FusionThread(const FusionSetup& setup, SlotRing<StreamItem>& in, SlotRing<CameraImage>& images,
               SlotRing<ReportItem>& out, Notifier& notifier);

  /// Runs until the item kEnd has been passed on, or `in` is closed.
  void run();

  /// Queues a command of the owner; from any thread.
  void post(const CalibrationCommand& command) { commands_.push(command); }

  /// Makes what finds the vehicle on these maps, for `post`, without the stated start; from any
  /// thread.
  std::shared_ptr<MapTasks> make_map_tasks(Maps maps) const;

  /// Queues tasks that take the place of those that run, which are in `tasks` afterwards: this
  /// thread does not destroy them. One that is null leaves the one that runs. From any thread.
  void post(std::shared_ptr<MapTasks> tasks) { commands_.push(std::move(tasks)); }

  /// Stops waiting for background work; from any thread.
  void shut_down();

 private:
  void process(Pin<StreamItem> item);
  void process_samples(const StreamItem& item);
  void process_due_sweeps();
  void process_sweep(Pin<StreamItem> item);
  bool is_behind(Duration lateness) const;
  bool measures_motion(LidarIndex lidar) const {
    return lidar_motion_ && lidar == 0 && odometry_.wants_lidar();
  }
  SweepSnapshot measure_motion(const StreamItem& item);
  SweepSnapshot deskew(const StreamItem& item);
  void report_sweep(const SweepSnapshot& snapshot);
  void localise(const SweepSnapshot& snapshot);
  void show(const SweepSnapshot& snapshot);
  const Sweep& nearest_sweep(Stamp exposure, const StreamItem& item) const;
  void process_last_images();
  void process_image(const CameraImage& image, const Sweep& sweep);
  void monitor_calibration(const ImageMatch& match);
  void report_latest_pose();
  void report_tick(const StreamItem& item);
  void handle(const CalibrationCommand& command);
  void handle(const std::shared_ptr<MapTasks>& next);
  void report(const CalibrationReport* calibration);

  ReportItem& begin_report(ReportItem::Kind kind, Stamp stamp);
  void send_report();
  void report(const PoseReport& pose);
  LatencyHistogram& latency(Stage stage) { return latencies_[static_cast<size_t>(stage)]; }

  /// Counters of one camera's images.
  struct ImageCounters {
    uint64_t used = 0;
    uint64_t unreadable = 0;
    uint64_t dropped = 0;  ///< without a sweep
  };

  FusionSetup setup_;
  SlotRing<StreamItem>& stream_;
  SlotRing<StreamItem>::Reader in_;
  SlotRing<ReportItem>& out_;
  Notifier& notifier_;

  OdometryTracker odometry_;
  SweepQueue sweeps_;
  std::vector<Pin<StreamItem>> previous_sweeps_;  // processed last, by LidarIndex
  ImageQueue images_;
  std::optional<LidarMotion> lidar_motion_;
  LidarIndex places_lidar_;                 // whose sweeps are compared with the map of keyframes
  std::mutex maps_mutex_;                   // of the pointers, to replace them and to shut down
  bool shut_down_ = false;                  // likewise
  MapTasks maps_;                           // what they point to is used by this thread alone
  std::deque<motion::Deskewer> deskewers_;  // by LidarIndex
  monitoring::CameraAssignment assignment_;
  std::deque<CameraChannel> cameras_;  // by CameraIndex
  ControlQueue<std::variant<CalibrationCommand, std::shared_ptr<MapTasks>>> commands_;
  motion::DeskewedSweep deskewed_;  // memory that is used again, as the next
  ViewMapPose view_pose_;

  Stamp now_ = Stamp::earliest();        // drive time
  HostClock::time_point read_at_;        // of the item in hand
  Duration behind_ = Duration::zero();   // host time since then
  Stamp last_pose_ = Stamp::earliest();  // of the last pose without a sweep
  uint64_t not_deskewed_ = 0;
  std::vector<uint64_t> dropped_sweeps_;       // by LidarIndex
  std::vector<ImageCounters> image_counters_;  // by CameraIndex
  std::array<LatencyHistogram, static_cast<size_t>(Stage::kCount)> latencies_;
  uint64_t deadline_misses_ = 0;
  uint64_t skipped_registrations_ = 0;
};

}  // namespace infuse::daemon
