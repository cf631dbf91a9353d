#include "daemon/protocol/request.hpp"

#include <nlohmann/json.hpp>

#include "daemon/protocol/number_json.hpp"
#include "drivers/recording/rigid_matrix.hpp"

namespace infuse::daemon {
namespace {

using UnorderedJson = nlohmann::json;

constexpr std::pair<const char*, Request::Op> kOps[] = {
    {"watch", Request::Op::kWatch},     {"poll", Request::Op::kPoll},
    {"devices", Request::Op::kDevices}, {"recalibrate", Request::Op::kRecalibrate},
    {"apply", Request::Op::kApply},     {"rollback", Request::Op::kRollback},
    {"freeze", Request::Op::kFreeze},   {"record", Request::Op::kRecord},
};

std::string known_ops() {
  std::string names = "known:";
  for (const auto& entry : kOps) names += std::string(" \"") + entry.first + '"';
  return names;
}

std::string known_classes() {
  std::string names = "known:";
  for (const auto& entry : kReportClasses) names += std::string(" \"") + entry.second + '"';
  return names;
}

/// Returns a name in quotes, shortened so that a reply stays small.
std::string quoted(const std::string& name) {
  constexpr size_t kMaxNameLength = 40;
  return "'" + (name.size() > kMaxNameLength ? name.substr(0, kMaxNameLength) + "..." : name) + "'";
}

Result<ReportClasses> parse_classes(const UnorderedJson& request) {
  const auto list = request.find("classes");
  if (list == request.end()) return ReportClasses::all();
  if (!list->is_array()) {
    return fail("classes is not a list", "watch", R"(e.g. "classes":["HEALTH","ALERT"])");
  }
  ReportClasses classes;
  for (const UnorderedJson& name : *list) {
    if (!name.is_string()) return fail("a class is not a string", "watch", known_classes());
    const auto& text = name.get_ref<const std::string&>();
    const auto value = report_class(text);
    if (!value) return fail("unknown class " + quoted(text), "watch", known_classes());
    classes.add(*value);
  }
  return classes;
}

Result<Request> parse_record(const UnorderedJson& json, Request request) {
  if (const auto name = json.find("name"); name != json.end()) {
    if (!name->is_string()) return fail("name is not a string", "record");
    request.name = name->get<std::string>();
  }
  if (const auto seconds = json.find("duration_s"); seconds != json.end()) {
    if (!seconds->is_number() || !(seconds->get<double>() > 0)) {
      return fail("duration_s is not a number greater than 0", "record");
    }
    request.max_duration = from_seconds(seconds->get<double>());
  }
  if (const auto bytes = json.find("max_bytes"); bytes != json.end()) {
    if (!bytes->is_number_unsigned() || bytes->get<uint64_t>() == 0) {
      return fail("max_bytes is not a whole number greater than 0", "record");
    }
    request.max_bytes = bytes->get<uint64_t>();
  }
  return request;
}

Result<Request> parse_apply(const UnorderedJson& json, Request request) {
  if (const auto number = json.find("number"); number != json.end()) {
    if (!number->is_number_unsigned()) return fail("number is not a whole number", "apply");
    request.number = number->get<uint64_t>();
  }
  if (const auto given = json.find("T_camera_lidar"); given != json.end()) {
    const auto numbers = numbers_of(*given, 16);
    request.T_camera_lidar = numbers ? recording::to_rigid(*numbers) : std::nullopt;
    if (!request.T_camera_lidar) {
      return fail("T_camera_lidar is not a rigid motion", "apply", "16 numbers by row");
    }
    if (request.device.empty()) {
      return fail("T_camera_lidar needs a device", "apply", "the name of a camera");
    }
  }
  return request;
}

Result<Request> parse_control(const UnorderedJson& json, Request request) {
  const std::string op = name_of(request.op);
  if (const auto device = json.find("device"); device != json.end()) {
    if (!device->is_string()) return fail("device is not a string", op, "the name of a camera");
    request.device = device->get<std::string>();
  }
  if (const auto on = json.find("on"); on != json.end()) {
    if (!on->is_boolean()) return fail("on is not a boolean", op);
    request.on = on->get<bool>();
  }
  if (request.op == Request::Op::kRecord) return parse_record(json, std::move(request));
  if (request.op == Request::Op::kApply) return parse_apply(json, std::move(request));
  return request;
}

}  // namespace

Result<Request> parse_request(std::string_view line) {
  if (line.size() > kMaxRequestBytes) {
    return fail("the request is longer than " + std::to_string(kMaxRequestBytes) + " bytes");
  }
  bool too_deep = false;
  const auto check_depth = [&](int depth, UnorderedJson::parse_event_t, UnorderedJson&) {
    too_deep = too_deep || depth > kMaxRequestDepth;
    return !too_deep;
  };
  const UnorderedJson request = UnorderedJson::parse(line.begin(), line.end(), check_depth, false);
  if (too_deep) {
    return fail("the request is nested deeper than " + std::to_string(kMaxRequestDepth));
  }
  if (request.is_discarded() || !request.is_object()) {
    return fail("the request is not a JSON object", "", R"(e.g. {"op":"poll"})");
  }
  const auto op = request.find("op");
  if (op == request.end() || !op->is_string()) {
    return fail("the request has no op", "", known_ops());
  }
  const auto& name = op->get_ref<const std::string&>();
  for (const auto& [its_name, value] : kOps) {
    if (name != its_name) continue;
    Request parsed{.op = value};
    if (parsed.is_control()) return parse_control(request, std::move(parsed));
    if (value != Request::Op::kWatch) return parsed;
    return parse_classes(request).map([&](ReportClasses classes) {
      parsed.classes = classes;
      return parsed;
    });
  }
  return fail("unknown op " + quoted(name), "", known_ops());
}

const char* name_of(Request::Op op) {
  for (const auto& [name, value] : kOps) {
    if (value == op) return name;
  }
  return "";
}

}  // namespace infuse::daemon
