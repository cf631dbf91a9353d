#include "daemon/pipeline/replay.hpp"

#include <algorithm>

#include "daemon/pipeline/threads.hpp"

namespace infuse::daemon {
namespace {

constexpr int kIoCore = 0;
constexpr int kFusionCore = 1;

StreamItem stream_item(const DriveSetup& setup) {
  StreamItem item;
  item.samples.reserve(Intake::kSamplesTogether);
  item.counters.resize(setup.lidars.size());
  item.streams.resize(setup.streams());
  return item;
}

ReportItem report_item(const DriveSetup& setup) {
  ReportItem item;
  item.counters.resize(setup.lidars.size());
  item.streams.resize(setup.streams());
  return item;
}

FusionSetup fusion_setup(const DriveSetup& setup, const ReplayOptions& options) {
  return {setup.rig, setup.vehicle.has_odometry(), options.odometry};
}

}  // namespace

Replay::Replay(boost::asio::io_context& io, DriveSetup setup, const ReplayOptions& options,
               Server& server, ReportsFile* file, std::function<void()> on_end)
    : setup_(std::move(setup)),
      on_end_(std::move(on_end)),
      items_(kItemsInFlight + FusionStage::pins(setup_.lidars.size()),
             [&] { return stream_item(setup_); }),
      pictures_(4 * setup_.cameras.size() + 2, [] { return Picture(); }),
      reports_(kReportsInFlight, [&] { return report_item(setup_); }),
      bell_(io, [this] { drain(); }),
      publisher_(reports_, setup_, options.health, server, file),
      fusion_(fusion_setup(setup_, options), items_, pictures_, reports_, bell_),
      decoder_(items_, pictures_, setup_.cameras),
      intake_(setup_, options.rate, items_) {}

// Closed rings let every stage go on to its end without waiting for the next.
Replay::~Replay() {
  stop();
  items_.close();
  pictures_.close();
  reports_.close();
}

void Replay::start() {
  fusion_thread_ = std::jthread([this] {
    name_and_pin("fusion", kFusionCore);
    fusion_.run();
  });
  picture_thread_ = std::jthread([this] {
    name_and_pin("pictures", kIoCore);
    decoder_.run();
  });
  io_thread_ = std::jthread([this](std::stop_token stop) {
    name_and_pin("io", kIoCore);
    intake_.run(stop);
  });
}

void Replay::stop() { io_thread_.request_stop(); }

void Replay::drain() {
  if (publisher_.drain()) bell_.ring();
  if (!publisher_.totals().ended || !fusion_thread_.joinable()) return;
  io_thread_.join();
  picture_thread_.join();
  fusion_thread_.join();
  bell_.close();
  on_end_();
}

std::vector<Error> Replay::notes() const {
  std::vector<Error> notes = setup_.source.notes();
  const std::vector<Error>& dbc = setup_.vehicle.notes;
  notes.insert(notes.end(), dbc.begin(), dbc.end());
  const std::span<const Error> bus = intake_.bus_problems().first();
  notes.insert(notes.end(), bus.begin(), bus.end());
  return notes;
}

std::optional<double> Replay::progress() const {
  if (setup_.capture_bytes == 0) return std::nullopt;
  const double read = static_cast<double>(intake_.capture_bytes());
  return std::min(read / static_cast<double>(setup_.capture_bytes), 1.0);
}

}  // namespace infuse::daemon
