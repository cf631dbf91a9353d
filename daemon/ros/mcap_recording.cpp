#include "daemon/ros/mcap_recording.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <tuple>

#include "daemon/ros/sensor_messages.hpp"

namespace infuse::daemon {

Result<std::unique_ptr<McapRecording>> McapRecording::create(const std::filesystem::path& path,
                                                             const MessageSetup& setup) {
  mcap::WriterOptions options;
  options.flush_chunks = true;
  auto file = RosFile::create(path, options);
  if (!file) return tl::unexpected(file.error());
  return std::unique_ptr<McapRecording>(new McapRecording(*std::move(file), setup));
}

McapRecording::McapRecording(RosFile file, const MessageSetup& setup)
    : file_(std::move(file)), live_(setup.live) {
  for (size_t k = 0; k < setup.rig.lidars.size(); ++k) {
    if (!replaces_clouds(setup.packet_makers[k])) continue;
    refused_.insert(LidarTopics(setup.rig.lidars[k].name).points_raw);
  }
  file_.write_metadata(SensorMessages(setup, file_).metadata());
  check();
}

bool McapRecording::wants(const std::string& topic) const {
  return !failed_.load(std::memory_order_relaxed) && !refused_.contains(topic);
}

void McapRecording::add(const std::string& topic, const char* type, Stamp log_time, bool latched,
                        std::span<const uint8_t> bytes) {
  if (failed_) return;
  if (live_) {
    file_.add(topic, type, log_time, latched, bytes);
    return check();
  }
  const auto second = static_cast<size_t>(seconds_[lane_] - written_);
  if (held_.size() <= second) held_.resize(second + 1);
  held_[second].push_back(
      {topic, type, log_time, latched, lane_, std::vector<uint8_t>(bytes.begin(), bytes.end())});
}

void McapRecording::end_second() {
  if (live_) return;
  ++seconds_[lane_];
  while (*std::ranges::min_element(seconds_) > written_) write_first_second();
}

void McapRecording::write_first_second() {
  ++written_;
  if (held_.empty()) return;
  std::vector<Held> messages = std::move(held_.front());
  held_.pop_front();
  std::ranges::stable_sort(
      messages, {}, [](const Held& message) { return std::tuple(message.log_time, message.lane); });
  for (const Held& message : messages)
    file_.add(message.topic, message.type, message.log_time, message.latched, message.bytes);
  check();
}

void McapRecording::check() {
  if (!file_.failed() || failed_.exchange(true)) return;
  spdlog::error("{}; nothing more is written to it", file_.error()->message());
}

Result<void> McapRecording::close() {
  while (!held_.empty()) write_first_second();
  return file_.close();
}

}  // namespace infuse::daemon
