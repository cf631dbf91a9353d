#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <optional>

#include "daemon/pipeline/pipeline.hpp"
#include "daemon/sensors/live_reader.hpp"
#include "daemon/setup/sensor_setup.hpp"

namespace infuse::daemon {

/// The pipeline, fed by the sensors of this host. No stage waits for another: data that a stage
/// does not process in time is overwritten and counted.
class LivePipeline {
 public:
  /// `on_end` is called on the thread of `io` when every report has been published and the threads
  /// have ended. `io`, `server` and `tap`, which may be null, must outlive this object.
  LivePipeline(boost::asio::io_context& io, SensorSetup setup, const PipelineOptions& options,
               Server& server, std::function<void()> on_end,
               const host::TimeBase& base = host::TimeBase(), RecordTap* tap = nullptr);

  /// Starts the threads.
  void start();

  /// Requests the end; `on_end` is still called.
  void stop() { pipeline_.stop(); }

  Pipeline& pipeline() { return pipeline_; }
  Publisher& publisher() { return pipeline_.publisher(); }
  const SensorSetup& setup() const { return setup_; }

 private:
  SensorSetup setup_;
  std::optional<LiveReader> reader_;  // must outlive the thread that runs it
  Pipeline pipeline_;
};

}  // namespace infuse::daemon
