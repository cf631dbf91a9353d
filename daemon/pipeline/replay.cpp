#include "daemon/pipeline/replay.hpp"

#include <algorithm>

#include "daemon/pipeline/threads.hpp"

namespace infuse::daemon {
namespace {

constexpr int kIoCore = 0;
constexpr int kFusionCore = 1;

StreamItem stream_item(size_t devices) {
  StreamItem item;
  item.counters.resize(devices);
  return item;
}

ReportItem report_item(size_t devices) {
  ReportItem item;
  item.counters.resize(devices);
  return item;
}

}  // namespace

Replay::Replay(boost::asio::io_context& io, DriveSetup setup, const ReplayOptions& options,
               Server& server, ReportsFile* file, std::function<void()> on_end)
    : setup_(std::move(setup)),
      on_end_(std::move(on_end)),
      sweeps_(kSweepsInFlight, [&] { return stream_item(setup_.lidars.size()); }),
      reports_(kReportsInFlight, [&] { return report_item(setup_.lidars.size()); }),
      bell_(io, [this] { drain(); }),
      publisher_(reports_, setup_.devices, options.health, server, file),
      fusion_(sweeps_, reports_, bell_),
      intake_(setup_.source, setup_.lidars, options.rate, sweeps_) {}

// Closed rings let every stage go on to its end without waiting for the next.
Replay::~Replay() {
  stop();
  sweeps_.close();
  reports_.close();
}

void Replay::start() {
  fusion_thread_ = std::jthread([this] {
    name_and_pin("fusion", kFusionCore);
    fusion_.run();
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
  fusion_thread_.join();
  bell_.close();
  on_end_();
}

std::optional<double> Replay::progress() const {
  if (setup_.capture_bytes == 0) return std::nullopt;
  const double read = static_cast<double>(intake_.capture_bytes());
  return std::min(read / static_cast<double>(setup_.capture_bytes), 1.0);
}

}  // namespace infuse::daemon
