#pragma once

#include <functional>
#include <memory>
#include <string>

#include "daemon/config/view_settings.hpp"
#include "daemon/pipeline/view_tap.hpp"
#include "daemon/protocol/reports.hpp"
#include "daemon/streetmap/street_map_file.hpp"
#include "daemon/view/view_command.hpp"
#include "daemon/view/viewer_channels.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::daemon {

/// Carries out what a page of a replay asks for.
using ReplayControl = std::function<void(const ViewCommand&)>;

/// Serves the page of the view, and over a WebSocket the reports, sweeps and images to pages that
/// are open; to viewers that speak Foxglove's protocol, the messages they subscribe to. Has a
/// thread of its own; the pipeline never waits for it, and a page that does not keep up loses
/// frames and gets their number. Read-only, but for the pace of a replay. A page that is opened
/// late gets the HEALTH, CALIBRATION and ALERT reports since the start, and of a replay the last
/// frames.
class ViewServer {
 public:
  /// `map`: what is beneath; empty: nothing. `tap` and `channels` (null: no viewers of others)
  /// outlive this. `control`: null for a live run. Errors: the address cannot be bound.
  static Result<std::unique_ptr<ViewServer>> start(const ViewSettings& settings, const Rig& rig,
                                                   const StreetMapFile& map, ViewTap& tap,
                                                   ReplayControl control,
                                                   ViewerChannels* channels = nullptr);
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  /// Port that was bound.
  uint16_t port() const;

  /// Address of the page, without its token: it may be logged.
  std::string address() const;

  /// Address of the page with its token, for who may open it.
  std::string page_address() const;

  /// Publishes a report, a line of JSON; from any thread.
  void publish(ReportClass report_class, const std::string& line);

  /// Draws another street map from now on; from any thread.
  void set_map(const StreetMapFile& map);

  /// Tells the pages, and those opened later, that the drive has ended; from any thread.
  void end_drive();

  /// Number of pages that are open; from any thread.
  size_t clients() const;

 private:
  class Impl;
  explicit ViewServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace infuse::daemon
