#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/ros/topics.hpp"
#include "drivers/measurement/stamp.hpp"

/// The WebSocket protocol of Foxglove, version 1: JSON texts, and messages with a binary header.
/// See docs/spec.md of foxglove/ws-protocol.
namespace infuse::daemon {

/// The subprotocol to speak with a client that offers `offered` (Sec-WebSocket-Protocol), the newer
/// one first; empty if it offers neither.
std::string_view choose_subprotocol(std::string_view offered);

/// Greets a client. `replay`: the server sends the time.
std::string server_info_text(const std::string& session, bool replay);

/// Advertises the topics; a topic's channel is its index.
std::string advertise_text(const std::vector<TopicInfo>& topics);

/// Shows a client a note. `level`: 0 information, 1 warning, 2 error.
std::string status_text(int level, const std::string& message);

/// A message for a subscription.
std::string message_data(uint32_t subscription, Stamp log_time, std::span<const uint8_t> payload);

/// The time of a replay.
std::string time_data(Stamp time);

/// What a client asks for.
struct ViewerRequest {
  struct Subscription {
    uint32_t id = 0, channel = 0;
    bool operator==(const Subscription&) const = default;
  };
  std::vector<Subscription> subscribe;
  std::vector<uint32_t> unsubscribe;
  std::string refused;  ///< why nothing is done; empty: something is
};

/// Reads a text of a client. Everything but subscriptions is refused.
ViewerRequest parse_viewer_request(std::string_view text);

}  // namespace infuse::daemon
