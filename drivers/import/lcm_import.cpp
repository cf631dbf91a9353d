#include "drivers/import/lcm_import.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "drivers/import/bag_sinks.hpp"
#include "drivers/import/import_files.hpp"
#include "drivers/import/lcm_packets.hpp"
#include "drivers/lcm/lcm_log.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/mapped_file.hpp"

namespace infuse::importers {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxLcmChannels = 10'000;
constexpr size_t kSampledMessages = 200;  // of a channel: by these it is judged
constexpr Duration kMaxOwnLag{10'000'000'000};
constexpr int64_t kMaxSeconds = std::numeric_limits<int32_t>::max();  // 2038

/// Calls `on_event` with the events of all files.
template <class OnEvent>
Result<void> for_each_event(const std::vector<fs::path>& files, std::vector<Error>* notes,
                            OnEvent on_event) {
  for (const fs::path& path : files) {
    const auto file = recording::MappedFile::open(path);
    if (!file) return tl::unexpected(file.error());
    const std::span bytes(reinterpret_cast<const uint8_t*>(file->bytes().data()),
                          file->bytes().size());
    auto reader = lcm::LcmReader::open(bytes, path.string());
    if (!reader) return tl::unexpected(reader.error());
    lcm::LcmEvent event;
    while (reader->next(event)) {
      if (auto done = on_event(event); !done) return done;
    }
    if (notes != nullptr) reader->append_notes(*notes);
  }
  return {};
}

/// Time before a packet, if it may be the time of the packet.
std::optional<Stamp> own_time(const EmbeddedPacket& packet, Stamp logged) {
  const int64_t logged_us = logged.ns() / 1000;
  const int64_t limit_us = kMaxOwnLag.count() / 1000;
  if (packet.time_us < logged_us - limit_us || packet.time_us > logged_us + limit_us ||
      packet.time_us < 0)
    return std::nullopt;
  return Stamp::from_ns(packet.time_us * 1000);
}

/// Finds out about the channels of logs.
class ChannelSurvey {
 public:
  void add(const lcm::LcmEvent& event) {
    auto found = channels_.find(event.channel);
    if (found == channels_.end()) {
      if (channels_.size() >= kMaxLcmChannels) return;
      found = channels_.try_emplace(std::string(event.channel)).first;
      found->second.channel.name = event.channel;
      found->second.channel.smallest = event.data.size();
      found->second.channel.first = found->second.channel.last = event.time;
    }
    auto& [channel, lags, packets, own_times] = found->second;
    channel.smallest = std::min(channel.smallest, event.data.size());
    channel.largest = std::max(channel.largest, event.data.size());
    channel.first = std::min(channel.first, event.time);
    channel.last = std::max(channel.last, event.time);
    if (++channel.messages > kSampledMessages) return;
    find_packets(event.data, found_);
    for (const EmbeddedPacket& packet : found_) {
      (packet.is_position() ? channel.has_positions : channel.has_data) = true;
      ++packets;
      if (const auto time = own_time(packet, event.time)) {
        ++own_times;
        lags.push_back(to_seconds(event.time - *time));
      }
    }
  }

  std::vector<LcmChannel> finish() {
    std::vector<LcmChannel> all;
    for (auto& [name, entry] : channels_) {
      LcmChannel& channel = entry.channel;
      channel.has_own_times = entry.packets > 0 && entry.own_times == entry.packets;
      if (channel.has_own_times) {
        std::ranges::sort(entry.lags);
        channel.lag = {entry.lags.size(), entry.lags[entry.lags.size() / 2], entry.lags.front(),
                       entry.lags.back()};
      }
      all.push_back(std::move(channel));
    }
    return all;
  }

 private:
  struct Entry {
    LcmChannel channel;
    std::vector<double> lags;
    size_t packets = 0, own_times = 0;
  };
  std::map<std::string, Entry, std::less<>> channels_;
  std::vector<EmbeddedPacket> found_;
};

/// "VELODYNE front" as the name of a lidar: "velodyne_front".
std::string lidar_name(const std::string& channel, const Rig& rig) {
  std::string name;
  for (const char c : channel) {
    const auto byte = static_cast<unsigned char>(c);
    name += std::isalnum(byte) != 0 || c == '-' ? static_cast<char>(std::tolower(byte)) : '_';
  }
  std::string unique = name;
  for (int k = 2; std::ranges::find(rig.lidars, unique, &LidarMount::name) != rig.lidars.end(); ++k)
    unique = name + "_" + std::to_string(k);
  return unique;
}

std::string describe_channels(const std::vector<LcmChannel>& channels) {
  constexpr size_t kMaxNamed = 40;
  std::string text;
  for (const LcmChannel& channel : channels) {
    if (&channel - channels.data() == kMaxNamed) return text + ", ...";
    text += (text.empty() ? "" : ", ") + channel.name + " (" + std::to_string(channel.messages) +
            " messages of " + std::to_string(channel.smallest);
    if (channel.largest != channel.smallest) text += " to " + std::to_string(channel.largest);
    text += " bytes)";
  }
  return text.empty() ? "none" : text;
}

/// Writes the packets of the channels that have any.
class LcmImport {
 public:
  LcmImport(const fs::path& drive, LcmImportSummary& summary) : drive_(drive), summary_(summary) {}

  Result<void> prepare() {
    description_.name = "LCM log";
    for (LcmChannel& channel : summary_.channels) {
      if (!channel.has_data) continue;
      const std::string name = lidar_name(channel.name, description_.rig);
      channel.use = "lidar " + name;
      description_.rig.lidars.emplace_back().name = name;
      description_.lidars.emplace_back().packets = name + ".pcap";
      auto sink = PacketSink::create(drive_ / (name + ".pcap"));
      if (!sink) return tl::unexpected(sink.error());
      sinks_.push_back(std::move(*sink));
      inputs_[channel.name] = {sinks_.size() - 1, channel.has_own_times};
      summary_.notes.push_back(
          {"a log of LCM does not state where the lidar is: its mounting is "
           "unknown",
           channel.name, "set T_vehicle_lidar in drive.toml"});
    }
    for (LcmChannel& channel : summary_.channels) {
      if (channel.has_data || !channel.has_positions) continue;
      if (sinks_.size() == 1) {
        channel.use = "positions of the lidar " + description_.rig.lidars[0].name;
        inputs_[channel.name] = {0, channel.has_own_times};
      } else {
        summary_.notes.push_back(
            {"position packets are not taken: there are several lidars that "
             "they may belong to",
             channel.name, ""});
      }
    }
    return {};
  }

  Result<void> add(const lcm::LcmEvent& event) {
    const auto found = inputs_.find(event.channel);
    if (found == inputs_.end()) return {};
    Input& input = found->second;
    PacketSink& sink = sinks_[input.lidar];
    find_packets(event.data, packets_);
    if (packets_.empty()) ++input.without_packets;
    for (const EmbeddedPacket& packet : packets_) {
      const auto own = input.has_own_times ? own_time(packet, event.time) : std::nullopt;
      if (input.has_own_times && !own) ++input.without_times;
      if (!input.has_own_times && packets_.size() > 1) ++input.with_shared_times;
      const Stamp stamp = own.value_or(event.time);
      if (stamp <= Stamp() || stamp.ns() / 1'000'000'000 > kMaxSeconds) {
        sink.skipped.add("has no time, or one after 2037");
        continue;
      }
      if (auto done = write(sink, packet, stamp); !done) return done;
    }
    return {};
  }

  Result<void> finish() {
    for (size_t k = 0; k < sinks_.size(); ++k) {
      PacketSink& sink = sinks_[k];
      if (auto done = sink.finish(); !done) return done;
      summary_.packets += sink.packets();
      sink.skipped.append_notes(description_.rig.lidars[k].name, summary_.notes);
      if (const auto model = sink.model()) description_.rig.lidars[k].model = model->name;
      if (sink.has_positions() && description_.gnss_lidar.empty())
        description_.gnss_lidar = description_.rig.lidars[k].name;
    }
    for (const auto& entry : inputs_) {
      const Input& input = entry.second;
      const auto note = [&](size_t count, const std::string& what) {
        if (count > 0)
          summary_.notes.push_back({std::to_string(count) + " " + what, entry.first, ""});
      };
      note(input.without_packets, "messages have no packet");
      note(input.without_times,
           "packets have the time at which they were logged: no other is near");
      note(input.with_shared_times, "packets share the time of their message");
    }
    return recording::write_drive_toml(drive_, description_);
  }

 private:
  struct Input {
    size_t lidar = 0;
    bool has_own_times = false;
    size_t without_packets = 0, without_times = 0, with_shared_times = 0;
  };

  Result<void> write(PacketSink& sink, const EmbeddedPacket& packet, Stamp stamp) {
    if (packet.is_position()) return sink.add_position(packet.payload, stamp);
    return sink.add(packet.payload, stamp);
  }

  const fs::path& drive_;
  LcmImportSummary& summary_;
  recording::DriveDescription description_;
  std::vector<PacketSink> sinks_;                     ///< one per lidar
  std::map<std::string, Input, std::less<>> inputs_;  ///< by channel
  std::vector<EmbeddedPacket> packets_;
};

}  // namespace

double LcmChannel::rate_hz() const {
  const double span = to_seconds(last - first);
  return messages > 1 && span > 0 ? static_cast<double>(messages - 1) / span : 0;
}

Result<LcmImportSummary> import_lcm(const std::vector<fs::path>& files, const fs::path& drive) {
  LcmImportSummary summary;
  ChannelSurvey survey;
  const auto surveyed = for_each_event(files, &summary.notes, [&](const lcm::LcmEvent& event) {
    survey.add(event);
    return Result<void>{};
  });
  if (!surveyed) return tl::unexpected(surveyed.error());
  summary.channels = survey.finish();
  if (std::ranges::none_of(summary.channels, &LcmChannel::has_data)) {
    return fail("has no channel with data packets of a lidar",
                files.empty() ? "" : files.front().string(),
                "channels: " + describe_channels(summary.channels));
  }
  if (auto made = make_empty_folder(drive); !made) return tl::unexpected(made.error());
  LcmImport import(drive, summary);
  if (auto done = import.prepare(); !done) return tl::unexpected(done.error());
  const auto written =
      for_each_event(files, nullptr, [&](const lcm::LcmEvent& event) { return import.add(event); });
  if (!written) return tl::unexpected(written.error());
  if (auto done = import.finish(); !done) return tl::unexpected(done.error());
  return summary;
}

}  // namespace infuse::importers
