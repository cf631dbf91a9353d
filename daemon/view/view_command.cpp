#include "daemon/view/view_command.hpp"

#include <charconv>

#include "daemon/protocol/json.hpp"

namespace infuse::daemon {
namespace {

std::optional<ViewCommand> parse_seek(const Json& value) {
  if (!value.is_string()) return std::nullopt;
  const std::string& text = value.get_ref<const std::string&>();
  if (text == "alert") return ViewCommand{.kind = ViewCommand::Kind::kSeekAlert};
  int64_t ns = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), ns);
  if (error != std::errc() || end != text.data() + text.size() || ns < 0) return std::nullopt;
  return ViewCommand{.kind = ViewCommand::Kind::kSeek, .stamp = Stamp::from_ns(ns)};
}

}  // namespace

std::optional<ViewCommand> parse_view_command(std::string_view text) {
  const Json command = Json::parse(text, nullptr, false);
  if (!command.is_object() || command.size() != 1) return std::nullopt;
  const Json& value = command.front();
  const std::string& key = command.begin().key();
  if (key == "seek") return parse_seek(value);
  if (key == "step" && value == true) return ViewCommand{.kind = ViewCommand::Kind::kStep};
  if (key == "rate" && value.is_number() && value >= 0.0 && value <= ViewCommand::kMaxRate) {
    return ViewCommand{.kind = ViewCommand::Kind::kRate, .rate = value.get<double>()};
  }
  return std::nullopt;
}

std::optional<bool> parse_profiles_wanted(std::string_view text) {
  const Json wish = Json::parse(text, nullptr, false);
  if (!wish.is_object() || wish.size() != 1 || wish.begin().key() != "profiles" ||
      !wish.front().is_boolean()) {
    return std::nullopt;
  }
  return wish.front().get<bool>();
}

}  // namespace infuse::daemon
