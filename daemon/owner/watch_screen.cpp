#include "daemon/owner/watch_screen.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "daemon/owner/report_text.hpp"

namespace infuse::daemon {
namespace {

/// The first `columns` characters of UTF-8 text, without control characters.
std::string clipped(const std::string& line, size_t columns) {
  std::string out;
  size_t characters = 0;
  for (const char c : line) {
    const auto byte = static_cast<unsigned char>(c);
    const bool continues = (byte & 0xC0) == 0x80;
    if (!continues && characters++ == columns) break;
    out.push_back(byte < 0x20 || byte == 0x7F ? '?' : c);
  }
  return out;
}

/// "[######··········] 4.1 of 12.0": a value against its threshold.
std::string bar(double value, double threshold) {
  constexpr int kCells = 24;
  const double share = threshold > 0 ? std::clamp(value / threshold, 0.0, 1.0) : 0;
  std::string cells;
  for (int i = 0; i < kCells; ++i) cells += i < static_cast<int>(share * kCells) ? '#' : '.';
  return fmt::format("[{}] {:.1f} of {:.1f}", cells, value, threshold);
}

std::string calibration_line(const Json& report) {
  std::string line =
      fmt::format("  {:<12} {:<12}", text_of(report, "device"), text_of(report, "state"));
  if (const auto at = report.find("evidence"); at != report.end() && at->is_object()) {
    line +=
        fmt::format(" {} nats, {}", bar(at->value("nats", 0.0), at->value("threshold_nats", 0.0)),
                    text_of(*at, "axis"));
  }
  return line + fmt::format(", {} evaluations, {} scenes{}{}",
                            report.value("evaluations", uint64_t{0}),
                            report.value("scenes", uint64_t{0}),
                            report.value("proposed", false) ? ", proposed: infuse apply" : "",
                            report.value("frozen", false) ? ", frozen" : "");
}

void append_lines(const std::string& text, std::vector<std::string>& lines) {
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
}

}  // namespace

void WatchScreen::add(const Json& message) {
  const std::string name = text_of(message, "class");
  if (name == "HEALTH") health_ = message;
  if (name == "POSE") poses_[text_of(message, "frame")] = message;
  if (name == "CALIBRATION") calibrations_[text_of(message, "device")] = message;
  if (name != "ALERT") return;
  const std::pair key(text_of(message, "device"), text_of(message, "id"));
  if (text_of(message, "state") == "raised") {
    alerts_[key] = message;
  } else {
    alerts_.erase(key);
  }
}

std::string WatchScreen::text(size_t columns, size_t rows) const {
  std::vector<std::string> lines;
  lines.push_back(health_.is_null() ? "infused: waiting for HEALTH"
                                    : fmt::format("infused: {} (running for {:.0f} s), {} alert(s)",
                                                  text_of(health_, "level"),
                                                  health_.value("drive_s", 0.0), alerts_.size()));
  for (const auto& [key, alert] : alerts_) {
    lines.push_back(fmt::format("  ! {} {}: {}", text_of(alert, "severity"), key.first,
                                text_of(alert, "what")));
    lines.emplace_back("      " + text_of(alert, "advice"));
  }
  if (!poses_.empty()) lines.emplace_back("Pose");
  for (const auto& [frame, pose] : poses_) append_lines("  " + report_text(pose), lines);
  if (!calibrations_.empty()) lines.emplace_back("Calibration: evidence of a drift");
  for (const auto& [camera, report] : calibrations_) lines.push_back(calibration_line(report));
  if (!health_.is_null()) {
    lines.emplace_back("Sensors");
    append_lines(health_text(health_), lines);
  }
  const bool fits = lines.size() <= rows;
  std::string out;
  for (size_t i = 0; i < rows; ++i) {
    if (i > 0) out += '\n';
    if (!fits && i + 1 == rows) {
      out += clipped("… more: a larger terminal, or infuse status", columns);
    } else if (i < lines.size()) {
      out += clipped(lines[i], columns);
    }
  }
  return out;
}

}  // namespace infuse::daemon
