#pragma once

#include <nlohmann/json.hpp>
#include <ranges>
#include <type_traits>

#include "daemon/protocol/descriptions.hpp"
#include "daemon/protocol/json.hpp"

namespace infuse::daemon {

template <class T>
Json encode(const T& value);

/// Visitor of a description that makes a JSON object.
class JsonEncoder {
 public:
  void message(const char* name, const char*) { object_["class"] = name; }

  template <class T>
  void field(const char* name, const T& value, const char* = "", const Metric& = {}) {
    object_[name] = encode(value);
  }
  template <class T>
  void field(const char* name, const std::optional<T>& value, const char* = "",
             const Metric& = {}) {
    if (value) object_[name] = encode(*value);
  }

  Json take() { return std::move(object_); }

 private:
  Json object_ = Json::object();
};

/// True for types of Eigen that are encoded by row.
template <class T>
concept EigenMatrix = requires(const T& matrix) {
  { matrix.rows() } -> std::convertible_to<Eigen::Index>;
  matrix(0, 0);
};

/// Encodes a value by its type: described structs as objects, ranges as arrays.
template <class T>
Json encode(const T& value) {
  if constexpr (std::is_same_v<T, Stamp>) {
    return value.ns();
  } else if constexpr (std::is_enum_v<T>) {
    return name_of(value);
  } else if constexpr (std::is_arithmetic_v<T> ||
                       std::is_convertible_v<const T&, std::string_view>) {
    return value;
  } else if constexpr (requires { value.value; }) {  // Limited, Choice
    return value.value;
  } else if constexpr (requires { value.linear(); }) {  // Isometry3d: its rows() is 3
    return encode(value.matrix());
  } else if constexpr (EigenMatrix<T>) {
    Json numbers = Json::array();
    for (Eigen::Index row = 0; row < value.rows(); ++row) {
      for (Eigen::Index column = 0; column < value.cols(); ++column) {
        numbers.push_back(value(row, column));
      }
    }
    return numbers;
  } else if constexpr (std::ranges::range<T>) {
    Json array = Json::array();
    for (const auto& element : value) array.push_back(encode(element));
    return array;
  } else {
    JsonEncoder encoder;
    describe(encoder, value);
    return encoder.take();
  }
}

}  // namespace infuse::daemon
