#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <optional>

#include "daemon/live/live_reader.hpp"
#include "daemon/live/live_setup.hpp"
#include "daemon/pipeline/pipeline.hpp"

namespace infuse::daemon {

/// The sensors of this host run through the pipeline. Nothing waits for anything: what a stage does
/// not take in time is overwritten, and counted.
class LivePipeline {
 public:
  /// `on_end` is called on the thread of `io` when everything was told and the threads have ended.
  /// `io`, `server` and `tap`, which may be null, outlive this.
  LivePipeline(boost::asio::io_context& io, LiveSetup setup, const PipelineOptions& options,
               Server& server, std::function<void()> on_end,
               const receive::TimeBase& base = receive::TimeBase(), RecordTap* tap = nullptr);

  /// Starts the threads.
  void start();

  /// Asks for the end; `on_end` still comes.
  void stop() { pipeline_.stop(); }

  /// Carries out what the owner asks for.
  Result<void> handle_request(const Request& request) { return pipeline_.handle_request(request); }

  Publisher& publisher() { return pipeline_.publisher(); }
  const LiveSetup& setup() const { return setup_; }

 private:
  LiveSetup setup_;
  std::optional<LiveReader> reader_;  // outlives the thread that runs it
  Pipeline pipeline_;
};

}  // namespace infuse::daemon
