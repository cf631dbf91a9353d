#include "daemon/owner/calibration_reports.hpp"

#include "daemon/owner/client.hpp"
#include "daemon/owner/report_text.hpp"

namespace infuse::daemon {

Result<std::vector<Json>> poll_calibrations(const std::string& socket, const std::string& camera) {
  auto client = Client::connect(socket);
  if (!client) return tl::unexpected(client.error());
  if (auto sent = client->send({{"op", "poll"}}); !sent) return tl::unexpected(sent.error());
  std::vector<Json> reports;
  while (true) {
    auto message = client->next(std::chrono::seconds(5));
    if (!message) return tl::unexpected(message.error());
    if (!*message) return fail("the daemon ended");
    Json& report = **message;
    if (text_of(report, "class") == "ACK") break;
    if (text_of(report, "class") != "CALIBRATION") continue;
    if (camera.empty() || text_of(report, "device") == camera) {
      reports.push_back(std::move(report));
    }
  }
  if (!reports.empty()) return reports;
  return fail("no calibration report yet" + (camera.empty() ? "" : " of '" + camera + "'"), "",
              "there is none where calibrations are not monitored");
}

}  // namespace infuse::daemon
