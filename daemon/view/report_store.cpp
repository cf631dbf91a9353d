#include "daemon/view/report_store.hpp"

#include <cstddef>
#include <utility>

namespace infuse::daemon {

bool ReportStore::wants(ReportClass report_class) {
  return report_class == ReportClass::kDevices || report_class == ReportClass::kHealth ||
         report_class == ReportClass::kCalibration || report_class == ReportClass::kAlert;
}

void ReportStore::add(ReportClass report_class, std::string line) {
  bytes_ += line.size();
  lines_.push_back({report_class, std::move(line)});
  if (bytes_ > max_bytes_) thin();
}

void ReportStore::thin() {
  std::vector<Line> kept;
  bytes_ = 0;
  size_t passed = 0;
  for (size_t i = 0; i < lines_.size(); ++i) {
    const bool rare = lines_[i].report_class == ReportClass::kAlert ||
                      lines_[i].report_class == ReportClass::kDevices;
    if (!rare && i < lines_.size() / 2 && passed++ % 2 == 1) continue;
    bytes_ += lines_[i].text.size();
    kept.push_back(std::move(lines_[i]));
  }
  lines_ = std::move(kept);
  if (bytes_ <= max_bytes_) return;
  // Alerts alone are too many: the oldest half goes.
  const auto middle = lines_.begin() + static_cast<std::ptrdiff_t>((lines_.size() + 1) / 2);
  for (auto line = lines_.begin(); line != middle; ++line) bytes_ -= line->text.size();
  lines_.erase(lines_.begin(), middle);
}

std::string ReportStore::text() const {
  std::string out;
  for (const Line& line : lines_) {
    if (!out.empty()) out += '\n';
    out += line.text;
  }
  return out;
}

}  // namespace infuse::daemon
