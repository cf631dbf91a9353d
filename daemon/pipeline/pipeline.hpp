#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <stop_token>
#include <string>
#include <thread>

#include "daemon/pipeline/fusion_thread.hpp"
#include "daemon/pipeline/image_thread.hpp"
#include "daemon/pipeline/intake.hpp"
#include "daemon/pipeline/notifier.hpp"
#include "daemon/pipeline/publisher.hpp"

namespace infuse::daemon {

/// Configured options of the pipeline.
struct PipelineOptions {
  HealthOptions health;
  OdometrySettings odometry;
  StreetMapSettings streetmap;
  Maps maps;
  CalibrationSettings calibration;
  std::string places_lidar;    ///< whose sweeps are compared with it; empty: the first
  ViewTap* view = nullptr;     ///< outlives the pipeline; null: nobody can look
  PipelineTap* tap = nullptr;  ///< outlives the pipeline; null: nobody wants copies
};

/// The threads and the rings between them, live and in a replay:
///
///     reader -> Intake -> ring of items -> FusionThread -> ring of reports -> Publisher -> Server
///     io thread              |             fusion thread                      thread of `io`
///                            -> ImageThread -> ring of images -> (FusionThread)
class Pipeline {
 public:
  /// `setup`, `io`, `server` and `file` (which may be null) outlive this. `on_end` is called on the
  /// thread of `io` when all was published and the threads have ended.
  Pipeline(boost::asio::io_context& io, const SensorSetup& setup, const PipelineOptions& options,
           Server& server, ReportsFile* file, std::function<void()> on_end);
  ~Pipeline();

  /// The intake, for the reader's events.
  Intake& intake() { return intake_; }
  const Intake& intake() const { return intake_; }

  /// Starts the threads; `read` runs on the io thread until its end or a requested stop, and calls
  /// `Intake::end` last.
  void start(std::function<void(std::stop_token)> read);

  /// Requests the reader's end and cancels background work; `on_end` is still called.
  void stop() {
    fusion_.shut_down();
    io_thread_.request_stop();
  }

  /// Hands a command of the owner to the calibration of a camera.
  void post(const CalibrationCommand& command) { fusion_.post(command); }

  /// Takes maps over, in place of those in use, which are freed before this returns, unless a stop
  /// is requested earlier. One that is empty leaves the one in use. From a thread that may wait.
  void replace(Maps maps, const std::stop_token& stop);

  /// The items of the io thread, for a further reader that is registered before `start`, with a
  /// pin.
  SlotRing<StreamItem>& items() { return items_; }

  Publisher& publisher() { return publisher_; }
  const Publisher& publisher() const { return publisher_; }

 private:
  static constexpr size_t kReportsInFlight = 64;

  void drain();

  std::function<void()> on_end_;
  SlotRing<StreamItem> items_;
  SlotRing<CameraImage> images_;
  SlotRing<ReportItem> reports_;
  Notifier notifier_;
  Publisher publisher_;
  FusionThread fusion_;
  ImageThread decoder_;
  Intake intake_;
  std::jthread fusion_thread_;
  std::jthread image_thread_;
  std::jthread io_thread_;
};

}  // namespace infuse::daemon
