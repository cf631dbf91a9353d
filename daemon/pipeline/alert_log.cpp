#include "daemon/pipeline/alert_log.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "daemon/protocol/names.hpp"

namespace infuse::daemon {
namespace {

// Ids of these two kinds of lines, for journalctl MESSAGE_ID=….
constexpr const char* kRaisedMessageId = "5b0f6d0c1c9e4a5e9d1f7a8e2c643b71";
constexpr const char* kClearedMessageId = "c2d7a1f4e83b4d0f8a6c95b0d41e7f26";

std::string line_text(const AlertReport& alert, uint64_t left_out) {
  const Finding& finding = alert.finding;
  const std::string more =
      left_out == 0 ? "" : fmt::format("; raised {} times more since the last line", left_out);
  if (alert.raised) {
    return fmt::format("{} raised ({}): {} ({}){}", alert.id(), name_of(finding.level),
                       finding.what, finding.advice, more);
  }
  return fmt::format("{} cleared after {:.1f} s: {}{}", alert.id(),
                     to_seconds(alert.stamp - finding.since), finding.what, more);
}

}  // namespace

void AlertLog::add(const AlertReport& alert, spdlog::level::level_enum max_level) {
  if (const auto line = this->line(alert)) {
    log_line(std::min(line->level, max_level), line->text, line->fields);
  }
}

std::optional<AlertLine> AlertLog::line(const AlertReport& alert) {
  Written& written = written_[alert.id()];
  if (alert.raised) {
    const Duration elapsed = alert.stamp - written.since;
    if (elapsed >= kInterval || elapsed < Duration::zero()) {
      written.since = alert.stamp;
      written.raised = 0;
    }
    if (written.raised == kMaxRaised) {
      ++written.left_out;
      return std::nullopt;
    }
    ++written.raised;
  } else if (!written.open) {
    return std::nullopt;
  }
  written.open = alert.raised;
  const bool severe = alert.raised && alert.finding.level >= Level::kError;
  return AlertLine{severe ? spdlog::level::err : spdlog::level::warn,
                   line_text(alert, std::exchange(written.left_out, 0)),
                   {{"MESSAGE_ID", alert.raised ? kRaisedMessageId : kClearedMessageId},
                    {"INFUSE_ALERT", alert.id()},
                    {"INFUSE_DEVICE", alert.device},
                    {"INFUSE_LEVEL", name_of(alert.finding.level)},
                    {"INFUSE_STATE", alert.raised ? "raised" : "cleared"},
                    {"INFUSE_ADVICE", alert.finding.advice}}};
}

}  // namespace infuse::daemon
