#pragma once

#include <memory>
#include <string>

#include "daemon/pipeline/pipeline.hpp"
#include "daemon/ros/lcm_publisher.hpp"
#include "daemon/ros/mcap_recording.hpp"
#include "daemon/ros/message_stream.hpp"
#include "daemon/view/viewer_channels.hpp"

namespace infuse::daemon {

/// The messages of a run: a file, the channels of viewers, LCM, and the thread that makes them.
/// Each is null where it is not wanted.
struct Messages {
  std::string path;  ///< of the file
  std::unique_ptr<McapRecording> file;
  std::unique_ptr<ViewerChannels> channels;
  std::unique_ptr<LcmPublisher> lcm;
  std::unique_ptr<MessageStream> stream;
};

/// Opens the file `path` (empty: none), with `viewers` channels, and LCM where it is enabled.
/// Errors: the file cannot be created, no socket.
Result<Messages> open_messages(const std::string& path, bool viewers, const LcmSettings& lcm,
                               const MessageSetup& setup);

/// Starts the stream of a pipeline that has been made with it as its tap, before that starts.
void start_messages(Messages& messages, Pipeline& pipeline, bool live);

/// Writes what waits, and closes the file; when the pipeline has ended. Logs what was dropped or
/// not written. Errors: the file could not be written.
Result<void> finish_messages(Messages& messages);

}  // namespace infuse::daemon
