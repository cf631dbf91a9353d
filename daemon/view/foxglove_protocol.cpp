#include "daemon/view/foxglove_protocol.hpp"

#include <array>
#include <cstring>
#include <limits>
#include <optional>

#include "daemon/protocol/json.hpp"
#include "drivers/ros/schemas.hpp"

namespace infuse::daemon {
namespace {

constexpr std::array<std::string_view, 2> kSubprotocols = {"foxglove.sdk.v1",
                                                           "foxglove.websocket.v1"};
constexpr char kMessageDataOpcode = 1, kTimeOpcode = 2;

template <class Number>
void append_number(std::string& data, Number value) {
  std::array<char, sizeof value> bytes;
  std::memcpy(bytes.data(), &value, sizeof value);  // little-endian, as the hosts are
  data.append(bytes.data(), bytes.size());
}

std::string_view trim(std::string_view text) {
  while (text.starts_with(' ') || text.starts_with('\t')) text.remove_prefix(1);
  while (text.ends_with(' ') || text.ends_with('\t')) text.remove_suffix(1);
  return text;
}

bool offers(std::string_view offered, std::string_view protocol) {
  while (!offered.empty()) {
    const size_t end = std::min(offered.find(','), offered.size());
    if (trim(offered.substr(0, end)) == protocol) return true;
    offered.remove_prefix(std::min(end + 1, offered.size()));
  }
  return false;
}

std::optional<uint32_t> id_of(const nlohmann::json& value) {
  if (!value.is_number_unsigned()) return std::nullopt;
  const auto number = value.get<uint64_t>();
  if (number > std::numeric_limits<uint32_t>::max()) return std::nullopt;
  return static_cast<uint32_t>(number);
}

ViewerRequest refuse(std::string reason) { return {.refused = std::move(reason)}; }

}  // namespace

std::string_view choose_subprotocol(std::string_view offered) {
  for (const std::string_view protocol : kSubprotocols) {
    if (offers(offered, protocol)) return protocol;
  }
  return {};
}

std::string server_info_text(const std::string& session, bool replay) {
  Json capabilities = Json::array();
  if (replay) capabilities.push_back("time");
  return json_text({{"op", "serverInfo"},
                    {"name", "infuse"},
                    {"capabilities", capabilities},
                    {"metadata", Json::object()},
                    {"sessionId", session}});
}

std::string advertise_text(const std::vector<TopicInfo>& topics) {
  Json channels = Json::array();
  for (size_t k = 0; k < topics.size(); ++k) {
    channels.push_back({{"id", k},
                        {"topic", topics[k].topic},
                        {"encoding", "cdr"},
                        {"schemaName", topics[k].type},
                        {"schemaEncoding", "ros2msg"},
                        {"schema", ros::schema_of(topics[k].type).value_or("")}});
  }
  return json_text({{"op", "advertise"}, {"channels", channels}});
}

std::string status_text(int level, const std::string& message) {
  return json_text({{"op", "status"}, {"level", level}, {"message", message}});
}

std::string message_data(uint32_t subscription, Stamp log_time, std::span<const uint8_t> payload) {
  std::string data;
  data.reserve(1 + sizeof subscription + sizeof(uint64_t) + payload.size());
  data += kMessageDataOpcode;
  append_number(data, subscription);
  append_number(data, static_cast<uint64_t>(log_time.ns()));
  data.append(reinterpret_cast<const char*>(payload.data()), payload.size());
  return data;
}

std::string time_data(Stamp time) {
  std::string data(1, kTimeOpcode);
  append_number(data, static_cast<uint64_t>(time.ns()));
  return data;
}

ViewerRequest parse_viewer_request(std::string_view text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) return refuse("not a JSON object");
  const auto op = json.find("op");
  const std::string name = op != json.end() && op->is_string() ? op->get<std::string>() : "";
  ViewerRequest request;
  if (name == "subscribe") {
    const auto list = json.find("subscriptions");
    if (list == json.end() || !list->is_array()) return refuse("subscriptions must be a list");
    for (const auto& each : *list) {
      const auto id = each.is_object() ? id_of(each.value("id", nlohmann::json())) : std::nullopt;
      const auto channel =
          each.is_object() ? id_of(each.value("channelId", nlohmann::json())) : std::nullopt;
      if (!id || !channel) return refuse("a subscription needs an id and a channelId");
      request.subscribe.push_back({*id, *channel});
    }
  } else if (name == "unsubscribe") {
    const auto list = json.find("subscriptionIds");
    if (list == json.end() || !list->is_array()) return refuse("subscriptionIds must be a list");
    for (const auto& each : *list) {
      const auto id = id_of(each);
      if (!id) return refuse("a subscription's id is a number");
      request.unsubscribe.push_back(*id);
    }
  } else {
    return refuse("this server accepts subscriptions only");
  }
  return request;
}

}  // namespace infuse::daemon
