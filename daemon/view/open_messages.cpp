#include "daemon/view/open_messages.hpp"

#include <spdlog/spdlog.h>

namespace infuse::daemon {

Result<Messages> open_messages(const std::string& path, bool viewers, const LcmSettings& lcm,
                               const MessageSetup& setup) {
  Messages messages{.path = path};
  std::vector<MessageSink*> sinks;
  if (!path.empty()) {
    auto file = McapRecording::create(path, setup);
    if (!file) return tl::unexpected(file.error());
    messages.file = *std::move(file);
    sinks.push_back(messages.file.get());
  }
  if (viewers) {
    messages.channels = std::make_unique<ViewerChannels>(setup);
    sinks.push_back(messages.channels.get());
  }
  if (lcm.enabled) {
    auto publisher = LcmPublisher::create(lcm, setup);
    if (!publisher) return tl::unexpected(publisher.error());
    messages.lcm = *std::move(publisher);
    sinks.push_back(messages.lcm.get());
  }
  if (sinks.empty()) return messages;
  messages.stream = std::make_unique<MessageStream>(
      setup, sinks, [always = messages.file || messages.lcm, channels = messages.channels.get()] {
        return always || (channels != nullptr && channels->wanted());
      });
  if (messages.channels)
    messages.channels->on_change([stream = messages.stream.get()] { stream->wake(); });
  return messages;
}

void start_messages(Messages& messages, Pipeline& pipeline, bool live) {
  MessageStream* stream = messages.stream.get();
  if (stream == nullptr) return;
  Publisher& publisher = pipeline.publisher();
  publisher.add_line_listener(
      [stream](ReportClass report_class, const std::string&, const std::string& line) {
        stream->add_report(report_class, line);
      });
  if (live) publisher.add_queue([stream] { return stream->stats(); });
  stream->start(pipeline.items());
}

Result<void> finish_messages(Messages& messages) {
  if (messages.stream) {
    messages.stream->finish();
    std::vector<Error> notes;
    messages.stream->append_notes(notes);
    if (messages.stream->lost() > 0) {
      notes.push_back({std::to_string(messages.stream->lost()) +
                           " items were dropped: the thread that makes messages did not keep up",
                       messages.path, ""});
    }
    if (messages.lcm && messages.lcm->failed() > 0)
      notes.push_back(
          {std::to_string(messages.lcm->failed()) + " messages could not be sent", "LCM", ""});
    for (const Error& note : notes) spdlog::warn("{}", note.message());
  }
  if (!messages.file) return {};
  const auto file = std::exchange(messages.file, nullptr);
  return file->close();
}

}  // namespace infuse::daemon
