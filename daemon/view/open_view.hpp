#pragma once

#include <functional>
#include <memory>

#include "daemon/config/view_settings.hpp"
#include "daemon/pipeline/publisher.hpp"
#include "daemon/pipeline/view_tap.hpp"
#include "daemon/view/view_server.hpp"

namespace infuse::daemon {

/// The view of a run: what the fusion thread gives, and who serves it. Both null without a view.
struct View {
  std::unique_ptr<ViewTap> tap;
  std::unique_ptr<ViewServer> server;
};

/// Opens the view, if it is enabled; `channels` (may be null) outlives it; `control`: null
/// for a live run. Errors: the port is taken.
Result<View> open_view(const ViewSettings& settings, const Rig& rig, const StreetMapFile& map,
                       ReplayControl control, ViewerChannels* channels = nullptr);

/// Gives the publisher's reports to the view. `on_sweep`, if not null, is called after each SWEEP.
void publish_to_view(const View& view, Publisher& publisher,
                     std::function<void()> on_sweep = nullptr);

}  // namespace infuse::daemon
