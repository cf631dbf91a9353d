#include "daemon/pipeline/pipeline.hpp"

#include <chrono>
#include <memory>
#include <utility>

#include "daemon/pipeline/odometry_plan.hpp"
#include "daemon/pipeline/threads.hpp"

namespace infuse::daemon {
namespace {

constexpr int kIoCore = 0;
constexpr int kFusionCore = 1;

/// Items besides those that fusion pins. Live, the allowed backlog of fusion: 0.2 s of a bus, two
/// cameras and a lidar.
size_t items_in_flight(bool live) { return live ? 32 : 4; }

StreamItem stream_item(const SensorSetup& setup) {
  StreamItem item;
  item.samples.reserve(Intake::kMaxSampleBatch);
  item.from_bus.reserve(Intake::kMaxSampleBatch);
  item.counters = SensorCounters(setup);
  return item;
}

ReportItem report_item(const SensorSetup& setup) {
  ReportItem item;
  item.counters = SensorCounters(setup);
  return item;
}

FusionSetup fusion_setup(const SensorSetup& setup, const PipelineOptions& options) {
  const OdometrySettings odometry = plan_odometry(options.odometry, setup);
  return {.rig = setup.rig,
          .has_odometry = setup.vehicle.has_odometry() || *odometry.use_lidar,
          .has_motion_sensor = setup.vehicle.has_motion_sensor(),
          .odometry = odometry,
          .calibration = options.calibration,
          .delivery = delivery_of(setup.live),
          .streetmap = options.streetmap,
          .maps = options.maps,
          .places_lidar = options.places_lidar,
          .view = options.view,
          .tap = options.tap};
}

}  // namespace

Pipeline::Pipeline(boost::asio::io_context& io, const SensorSetup& setup,
                   const PipelineOptions& options, Server& server, ReportsFile* file,
                   std::function<void()> on_end)
    : on_end_(std::move(on_end)),
      items_(items_in_flight(setup.live) + FusionThread::max_pins(setup.lidars.size()) +
                 (options.tap != nullptr ? 1 : 0),
             [&] { return stream_item(setup); }),
      images_(4 * setup.cameras.size() + 2, [] { return CameraImage(); }),
      reports_(kReportsInFlight, [&] { return report_item(setup); }),
      notifier_(io, [this] { drain(); }),
      publisher_(reports_, setup, options.health, server, file),
      fusion_(fusion_setup(setup, options), items_, images_, reports_, notifier_),
      decoder_(items_, images_, setup),
      intake_(setup, items_, options.tap) {}

// Closed rings let every thread end without waiting for the next.
Pipeline::~Pipeline() {
  stop();
  items_.close();
  images_.close();
  reports_.close();
}

void Pipeline::start(std::function<void(std::stop_token)> read) {
  fusion_thread_ = std::jthread([this] {
    name_and_pin("fusion", kFusionCore);
    fusion_.run();
  });
  image_thread_ = std::jthread([this] {
    name_and_pin("images", kIoCore);
    decoder_.run();
  });
  io_thread_ = std::jthread([read = std::move(read)](std::stop_token stop) {
    name_and_pin("io", kIoCore);
    read(stop);
  });
}

// What was in use may have background work, whose end is waited for here: neither the fusion thread
// nor that of `io` may wait for it.
void Pipeline::replace(Maps maps, const std::stop_token& stop) {
  constexpr std::chrono::milliseconds kPause{10};
  const std::shared_ptr<MapTasks> tasks = fusion_.make_map_tasks(std::move(maps));
  fusion_.post(tasks);
  while (tasks.use_count() > 1 && !stop.stop_requested()) std::this_thread::sleep_for(kPause);
}

void Pipeline::drain() {
  if (publisher_.drain()) notifier_.notify();
  if (!publisher_.totals().ended || !fusion_thread_.joinable()) return;
  io_thread_.join();
  image_thread_.join();
  fusion_thread_.join();
  notifier_.close();
  on_end_();
}

}  // namespace infuse::daemon
