#include "daemon/history/saved_state.hpp"

#include <nlohmann/json.hpp>

#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxBytes = 64 << 10;
constexpr size_t kFormattedBytes = 512;  // of a state file: more than its numbers can take

/// Reads a non-negative integer; false if it is missing or out of range.
bool read(const nlohmann::json& json, const char* key, uint64_t& value) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number_unsigned()) return false;
  value = found->get<uint64_t>();
  return value <= static_cast<uint64_t>(INT64_MAX);
}

}  // namespace

std::string format_state(const SavedState& state) {
  const nlohmann::json json = {
      {"form", kSavedStateForm},         {"starts", state.starts},
      {"unclean", state.unclean_exits},  {"running", state.running},
      {"saved_ns", state.saved_at.ns()}, {"running_for_ns", state.total_run_time.count()}};
  std::string text = json.dump(2);
  if (const size_t bytes = text.size() + 1; bytes < kFormattedBytes) {
    text.insert(text.size() - 1, kFormattedBytes - bytes, ' ');  // before the last brace
  }
  return text + "\n";
}

Result<SavedState> parse_state(std::string_view text) {
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  SavedState state;
  uint64_t form = 0, saved = 0, running_for = 0;
  if (!json.is_object() || !read(json, "form", form) || form != kSavedStateForm) {
    return fail("not a state file of this release");
  }
  const auto running = json.find("running");
  if (!read(json, "starts", state.starts) || !read(json, "unclean", state.unclean_exits) ||
      !read(json, "saved_ns", saved) || !read(json, "running_for_ns", running_for) ||
      running == json.end() || !running->is_boolean()) {
    return fail("damaged state file");
  }
  state.running = running->get<bool>();
  state.saved_at = Stamp::from_ns(static_cast<int64_t>(saved));
  state.total_run_time = Duration(static_cast<int64_t>(running_for));
  return state;
}

Result<std::optional<SavedState>> read_state(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::optional<SavedState>();
  const auto text = text::read_text(path, kMaxBytes);
  if (!text) return tl::unexpected(text.error());
  auto state = parse_state(*text);
  if (!state)
    return fail(state.error().what, path.string(),
                "a new one is started; this is kept as *.unreadable");
  return std::optional<SavedState>(*state);
}

}  // namespace infuse::daemon
