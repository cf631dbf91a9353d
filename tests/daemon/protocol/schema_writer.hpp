#pragma once

#include <nlohmann/json.hpp>
#include <ranges>
#include <string>

#include "daemon/protocol/descriptions.hpp"

namespace infuse::daemon {

/// JSON whose objects keep the order in which their keys were set.
using OrderedJson = nlohmann::ordered_json;

template <class T>
OrderedJson schema_of(const T& value);

/// Visitor of a description that makes the JSON Schema of an object.
class SchemaWriter {
 public:
  void message(const char* name, const char* text) {
    title_ = name;
    text_ = text;
    properties_["class"] = {{"const", name}};
    required_.push_back("class");
  }

  template <class T>
  void field(const char* name, const T& value, const char* text = "", const Metric& = {}) {
    required_.push_back(name);
    add(name, schema_of(value), text);
  }
  template <class T>
  void field(const char* name, const std::optional<T>& value, const char* text = "",
             const Metric& = {}) {
    add(name, schema_of(value ? *value : T{}), text);
  }

  /// The schema of the object.
  OrderedJson take() const {
    OrderedJson schema;
    if (!title_.empty()) {
      schema["$schema"] = "http://json-schema.org/draft-07/schema#";
      schema["title"] = title_;
    }
    schema["type"] = "object";
    if (!text_.empty()) schema["description"] = text_;
    schema["properties"] = properties_;
    schema["required"] = required_;
    schema["additionalProperties"] = false;
    return schema;
  }

 private:
  void add(const char* name, OrderedJson schema, const std::string& text) {
    if (!text.empty()) schema["description"] = text;
    properties_[name] = std::move(schema);
  }

  std::string title_, text_;
  OrderedJson properties_ = OrderedJson::object();
  OrderedJson required_ = OrderedJson::array();
};

/// Returns the schema of an array of `size` numbers; 0: any number of elements.
inline OrderedJson array_schema(OrderedJson items, size_t size) {
  OrderedJson schema = {{"type", "array"}, {"items", std::move(items)}};
  if (size > 0) {
    schema["minItems"] = size;
    schema["maxItems"] = size;
  }
  return schema;
}

template <class T, int kMin, int kMax>
OrderedJson schema_of_limited(const Limited<T, kMin, kMax>&) {
  OrderedJson schema = schema_of(T{});
  schema["minimum"] = kMin;
  if (kMax >= kMin) schema["maximum"] = kMax;
  return schema;
}

template <const auto& kChoices>
OrderedJson schema_of_limited(const Choice<kChoices>&) {
  return {{"enum", std::vector<std::string>(kChoices.begin(), kChoices.end())}};
}

/// Returns the JSON Schema of a value by its type; mirrors `encode`.
template <class T>
OrderedJson schema_of(const T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    return {{"type", "boolean"}};
  } else if constexpr (std::is_same_v<T, Stamp>) {
    return {{"type", "integer"}};
  } else if constexpr (std::is_enum_v<T>) {
    OrderedJson names = OrderedJson::array();
    for (int i = static_cast<int>(kRange<T>[0]); i <= static_cast<int>(kRange<T>[1]); ++i) {
      names.push_back(name_of(static_cast<T>(i)));
    }
    return {{"enum", std::move(names)}};
  } else if constexpr (std::is_unsigned_v<T>) {
    return {{"type", "integer"}, {"minimum", 0}};
  } else if constexpr (std::is_integral_v<T>) {
    return {{"type", "integer"}};
  } else if constexpr (std::is_floating_point_v<T>) {
    return {{"type", "number"}};
  } else if constexpr (std::is_convertible_v<const T&, std::string_view>) {
    return {{"type", "string"}, {"minLength", 1}};
  } else if constexpr (requires { value.value; }) {
    return schema_of_limited(value);
  } else if constexpr (requires { value.linear(); }) {
    return schema_of(value.matrix());
  } else if constexpr (requires { value.rows(); }) {
    return array_schema({{"type", "number"}}, static_cast<size_t>(value.rows() * value.cols()));
  } else if constexpr (requires { std::tuple_size<T>::value; }) {
    return array_schema(schema_of(value[0]), value.size());
  } else if constexpr (std::ranges::range<T>) {
    return array_schema(schema_of(typename T::value_type{}), 0);
  } else {
    SchemaWriter writer;
    describe(writer, value);
    return writer.take();
  }
}

/// Returns a JSON text in which a value takes a line of its own only where it does not fit.
inline std::string pretty(const OrderedJson& json, size_t indent = 0) {
  constexpr size_t kWidth = 118;
  const std::string flat = json.dump(-1, ' ');
  if (json.is_primitive() || json.empty() || (indent > 0 && flat.size() + indent < kWidth - 20)) {
    std::string spaced;
    bool quoted = false;
    for (size_t i = 0; i < flat.size(); ++i) {
      if (flat[i] == '"' && (i == 0 || flat[i - 1] != '\\')) quoted = !quoted;
      spaced += flat[i];
      if (!quoted && (flat[i] == ',' || flat[i] == ':')) spaced += ' ';
    }
    return spaced;
  }
  const std::string inner(indent + 2, ' ');
  std::string text = json.is_object() ? "{\n" : "[\n";
  size_t left = json.size();
  for (const auto& [key, value] : json.items()) {
    text += inner + (json.is_object() ? "\"" + key + "\": " : "") + pretty(value, indent + 2) +
            (--left > 0 ? ",\n" : "\n");
  }
  return text + std::string(indent, ' ') + (json.is_object() ? "}" : "]");
}

}  // namespace infuse::daemon
