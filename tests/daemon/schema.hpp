#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "tests/folders.hpp"

namespace infuse::daemon {

/// Returns daemon/<name>.schema.json, read once; null if there is none.
inline const valijson::Schema* load_schema(const std::string& name) {
  static std::map<std::string, std::unique_ptr<valijson::Schema>> read;
  const auto known = read.find(name);
  if (known != read.end()) return known->second.get();
  std::ifstream file(std::filesystem::path(source_folder()) / "daemon" / (name + ".schema.json"));
  if (!file) return nullptr;
  const nlohmann::json json = nlohmann::json::parse(file);
  auto schema = std::make_unique<valijson::Schema>();
  valijson::SchemaParser(valijson::SchemaParser::kDraft7)
      .populateSchema(valijson::adapters::NlohmannJsonAdapter(json), *schema);
  return (read[name] = std::move(schema)).get();
}

/// Validates `value` by the schema of that name.
inline testing::AssertionResult matches_schema(const nlohmann::json& value,
                                               const std::string& name) {
  const valijson::Schema* schema = load_schema(name);
  if (schema == nullptr) return testing::AssertionFailure() << "no schema of " << name;
  valijson::Validator validator(valijson::Validator::kStrongTypes);
  valijson::ValidationResults results;
  if (validator.validate(*schema, valijson::adapters::NlohmannJsonAdapter(value), &results)) {
    return testing::AssertionSuccess();
  }
  auto failure = testing::AssertionFailure() << value.dump() << "\nis not a valid " << name << ":";
  valijson::ValidationResults::Error error;
  while (results.popError(error)) {
    failure << "\n ";
    for (const std::string& step : error.context) failure << step;
    failure << " " << error.description;
  }
  return failure;
}

/// Validates a message by the schema of its class.
inline testing::AssertionResult is_valid_message(const std::string& line) {
  const auto json = nlohmann::json::parse(line, nullptr, false);
  if (!json.is_object() || !json.contains("class")) {
    return testing::AssertionFailure() << "no message: " << line;
  }
  std::string name = json["class"];
  std::transform(name.begin(), name.end(), name.begin(), [](char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  });
  return matches_schema(json, "protocol/" + name);
}

/// Validates what a command printed with --json by daemon/results/<name>.schema.json.
inline testing::AssertionResult is_result(const std::string& output, const std::string& name) {
  const auto json = nlohmann::json::parse(output, nullptr, false);
  if (!json.is_object()) return testing::AssertionFailure() << "no result: " << output;
  return matches_schema(json, "results/" + name);
}

}  // namespace infuse::daemon
