#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <optional>
#include <thread>

#include "daemon/pipeline/doorbell.hpp"
#include "daemon/pipeline/drive_setup.hpp"
#include "daemon/pipeline/fusion_stage.hpp"
#include "daemon/pipeline/intake.hpp"
#include "daemon/pipeline/picture_stage.hpp"
#include "daemon/pipeline/publisher.hpp"

namespace infuse::daemon {

/// How a drive is replayed.
struct ReplayOptions {
  std::optional<double> rate;  ///< 1: as it was recorded; nothing: as fast as it goes
  HealthOptions health;
  OdometrySettings odometry;
};

/// A drive run through the pipeline:
///
///     drive -> Intake -> ring of items -> FusionStage -> ring of reports -> Publisher -> Server
///              io thread      |           fusion thread                     the thread of io
///                             -> PictureStage -> ring of pictures -> (FusionStage)
///
/// In drive time: each stage waits for the next one, nothing is dropped, and the reports are a
/// function of the drive alone.
class Replay {
 public:
  /// `on_end` is called on the thread of `io` when everything was told and the threads have ended.
  /// `io`, `server` and `file` (which may be null) outlive this.
  Replay(boost::asio::io_context& io, DriveSetup setup, const ReplayOptions& options,
         Server& server, ReportsFile* file, std::function<void()> on_end);
  ~Replay();

  /// Starts the threads.
  void start();

  /// Asks for an end before the drive's; `on_end` still comes.
  void stop();

  /// For whoever keeps the poses; before `start`.
  Publisher& publisher() { return publisher_; }

  const Totals& totals() const { return publisher_.totals(); }
  const DriveSetup& setup() const { return setup_; }

  /// What was wrong with the files; after the end.
  std::vector<Error> notes() const;

  /// How much of the captures has been read, 0 … 1; nothing where the drive has none.
  std::optional<double> progress() const;

 private:
  static constexpr size_t kItemsInFlight = 4;  // beside those that fusion holds
  static constexpr size_t kReportsInFlight = 64;

  void drain();

  DriveSetup setup_;
  std::function<void()> on_end_;
  SlotRing<StreamItem> items_;
  SlotRing<Picture> pictures_;
  SlotRing<ReportItem> reports_;
  Doorbell bell_;
  Publisher publisher_;
  FusionStage fusion_;
  PictureStage decoder_;
  Intake intake_;
  std::jthread fusion_thread_;
  std::jthread picture_thread_;
  std::jthread io_thread_;
};

}  // namespace infuse::daemon
