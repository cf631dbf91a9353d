#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <optional>

#include "daemon/pipeline/drive_reader.hpp"
#include "daemon/pipeline/pipeline.hpp"
#include "daemon/setup/sensor_setup.hpp"

namespace infuse::daemon {

/// Options of a replay.
struct ReplayOptions {
  std::optional<double> rate;  ///< 1: real time; nothing: as fast as possible
  PipelineOptions pipeline;
};

/// Runs a drive through the pipeline, in drive time: each thread waits for the next one, nothing is
/// dropped, and the reports depend on the drive alone.
class Replay {
 public:
  /// `on_end` is called on the thread of `io` when all was published and the threads have ended.
  /// `io`, `server` and `file` (which may be null) outlive this.
  Replay(boost::asio::io_context& io, SensorSetup setup, const ReplayOptions& options,
         Server& server, ReportsFile* file, std::function<void()> on_end);

  /// Starts the threads.
  void start();

  /// Ends the replay early; `on_end` is still called.
  void stop() { pipeline_.stop(); }

  /// The pace, which any thread may change.
  Pacer& pacer() { return reader_->pacer(); }

  Pipeline& pipeline() { return pipeline_; }

  /// The publisher, for registering listeners before `start`.
  Publisher& publisher() { return pipeline_.publisher(); }

  const Totals& totals() const { return pipeline_.publisher().totals(); }
  const SensorSetup& setup() const { return setup_; }

  /// Returns the problems of the files; after the end.
  std::vector<Error> notes() const;

  /// Returns the fraction of the captures read, 0 … 1; nothing without captures.
  std::optional<double> progress() const;

 private:
  SensorSetup setup_;
  std::optional<DriveReader> reader_;  // outlives its thread
  Pipeline pipeline_;
};

}  // namespace infuse::daemon
