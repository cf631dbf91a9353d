#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <optional>

#include "daemon/pipeline/drive_reader.hpp"
#include "daemon/pipeline/drive_setup.hpp"
#include "daemon/pipeline/pipeline.hpp"

namespace infuse::daemon {

/// How a drive is replayed.
struct ReplayOptions {
  std::optional<double> rate;  ///< 1: as it was recorded; nothing: as fast as it goes
  PipelineOptions pipeline;
};

/// A drive run through the pipeline, in drive time: each stage waits for the next one, nothing is
/// dropped, and the reports are a function of the drive alone.
class Replay {
 public:
  /// `on_end` is called on the thread of `io` when everything was told and the threads have ended.
  /// `io`, `server` and `file` (which may be null) outlive this.
  Replay(boost::asio::io_context& io, DriveSetup setup, const ReplayOptions& options,
         Server& server, ReportsFile* file, std::function<void()> on_end);

  /// Starts the threads.
  void start();

  /// Asks for an end before the drive's; `on_end` still comes.
  void stop() { pipeline_.stop(); }

  Pipeline& pipeline() { return pipeline_; }
  Publisher& publisher() { return pipeline_.publisher(); }

  const Totals& totals() const { return pipeline_.publisher().totals(); }
  const DriveSetup& setup() const { return setup_; }

  /// What was wrong with the files; after the end.
  std::vector<Error> notes() const;

  /// How much of the captures has been read, 0 … 1; nothing where the drive has none.
  std::optional<double> progress() const;

 private:
  DriveSetup setup_;
  std::optional<DriveReader> reader_;  // outlives the thread that runs it
  Pipeline pipeline_;
};

}  // namespace infuse::daemon
