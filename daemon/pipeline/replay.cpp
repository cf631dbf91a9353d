#include "daemon/pipeline/replay.hpp"

#include <algorithm>

namespace infuse::daemon {

Replay::Replay(boost::asio::io_context& io, SensorSetup setup, const ReplayOptions& options,
               Server& server, ReportsFile* file, std::function<void()> on_end)
    : setup_(std::move(setup)),
      pipeline_(io, setup_, options.pipeline, server, file, std::move(on_end)) {
  reader_.emplace(setup_.source, options.rate, pipeline_.intake());
}

void Replay::start() {
  pipeline_.start([this](std::stop_token stop) { reader_->run(stop); });
}

std::vector<Error> Replay::notes() const {
  std::vector<Error> notes = setup_.source.notes();
  for (const auto* more : {&setup_.doubts, &setup_.vehicle.notes}) {
    notes.insert(notes.end(), more->begin(), more->end());
  }
  const std::span<const Error> bus = pipeline_.intake().bus_problems().first();
  notes.insert(notes.end(), bus.begin(), bus.end());
  return notes;
}

std::optional<double> Replay::progress() const {
  if (setup_.capture_bytes == 0) return std::nullopt;
  const double read = static_cast<double>(reader_->capture_bytes());
  return std::min(read / static_cast<double>(setup_.capture_bytes), 1.0);
}

}  // namespace infuse::daemon
