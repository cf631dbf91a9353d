#include "daemon/view/open_view.hpp"

#include <spdlog/spdlog.h>

namespace infuse::daemon {

Result<View> open_view(const ViewSettings& settings, const Rig& rig, const StreetMapFile& map,
                       ReplayControl control, ViewerChannels* channels) {
  View view;
  if (!settings.enabled()) return view;
  view.tap = std::make_unique<ViewTap>(rig.cameras.size());
  auto server = ViewServer::start(settings, rig, map, *view.tap, std::move(control), channels);
  if (!server) return tl::unexpected(server.error());
  view.server = *std::move(server);
  spdlog::info("view: {}{}", view.server->address(),
               settings.token.empty() ? "" : ", with the token of [view]");
  return view;
}

void publish_to_view(const View& view, Publisher& publisher, std::function<void()> on_sweep) {
  if (!view.server) return;
  publisher.add_line_listener(
      [server = view.server.get(), on_sweep = std::move(on_sweep)](
          ReportClass report_class, const std::string&, const std::string& line) {
        server->publish(report_class, line);
        if (report_class == ReportClass::kSweep && on_sweep) on_sweep();
      });
}

}  // namespace infuse::daemon
