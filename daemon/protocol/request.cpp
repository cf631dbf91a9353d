#include "daemon/protocol/request.hpp"

#include <nlohmann/json.hpp>

namespace infuse::daemon {
namespace {

using Json = nlohmann::json;

constexpr const char* kKnownOps = R"(known: "watch", "poll", "devices")";

std::string known_classes() {
  std::string names = "known:";
  for (const auto& entry : kReportClasses) names += std::string(" \"") + entry.second + '"';
  return names;
}

/// Names that go back to the client, shortened so that a reply stays small.
std::string quoted(const std::string& name) {
  constexpr size_t kLongest = 40;
  return "'" + (name.size() > kLongest ? name.substr(0, kLongest) + "..." : name) + "'";
}

Result<ReportClasses> parse_classes(const Json& request) {
  const auto list = request.find("classes");
  if (list == request.end()) return ReportClasses::all();
  if (!list->is_array()) {
    return fail("classes is not a list", "watch", R"(e.g. "classes":["HEALTH","ALERT"])");
  }
  ReportClasses classes;
  for (const Json& name : *list) {
    if (!name.is_string()) return fail("a class is not a string", "watch", known_classes());
    const auto& text = name.get_ref<const std::string&>();
    const auto value = report_class(text);
    if (!value) return fail("unknown class " + quoted(text), "watch", known_classes());
    classes.add(*value);
  }
  return classes;
}

}  // namespace

Result<Request> parse_request(std::string_view line) {
  if (line.size() > kMaxRequestBytes) {
    return fail("the request is longer than " + std::to_string(kMaxRequestBytes) + " bytes");
  }
  bool too_deep = false;
  const auto check_depth = [&](int depth, Json::parse_event_t, Json&) {
    too_deep = too_deep || depth > kMaxRequestDepth;
    return !too_deep;
  };
  const Json request = Json::parse(line.begin(), line.end(), check_depth, false);
  if (too_deep) {
    return fail("the request is nested deeper than " + std::to_string(kMaxRequestDepth));
  }
  if (request.is_discarded() || !request.is_object()) {
    return fail("the request is not a JSON object", "", R"(e.g. {"op":"poll"})");
  }
  const auto op = request.find("op");
  if (op == request.end() || !op->is_string()) {
    return fail("the request has no op", "", kKnownOps);
  }
  const auto& name = op->get_ref<const std::string&>();
  if (name == "poll") return Request{Request::Op::kPoll, {}};
  if (name == "devices") return Request{Request::Op::kDevices, {}};
  if (name == "watch") {
    return parse_classes(request).map([](ReportClasses classes) {
      return Request{Request::Op::kWatch, classes};
    });
  }
  return fail("unknown op " + quoted(name), "", kKnownOps);
}

const char* name_of(Request::Op op) {
  switch (op) {
    case Request::Op::kWatch:
      return "watch";
    case Request::Op::kPoll:
      return "poll";
    case Request::Op::kDevices:
      return "devices";
  }
  return "";
}

}  // namespace infuse::daemon
