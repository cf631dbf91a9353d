#include "drivers/vehicle/signal_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/measurement/angles.hpp"

namespace infuse::vehicle {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

enum class Dimension { kSpeed, kAngularVelocity, kAngle, kAcceleration, kNone };

struct Unit {
  std::string_view name;
  Dimension dimension;
  double factor;  ///< conversion to SI
};

constexpr Unit kUnits[] = {
    {"m/s", Dimension::kSpeed, 1},
    {"mps", Dimension::kSpeed, 1},
    {"km/h", Dimension::kSpeed, 1 / 3.6},
    {"kph", Dimension::kSpeed, 1 / 3.6},
    {"kmh", Dimension::kSpeed, 1 / 3.6},
    {"mph", Dimension::kSpeed, 0.44704},
    {"rad/s", Dimension::kAngularVelocity, 1},
    {"deg/s", Dimension::kAngularVelocity, kDegree},
    {"deg/sec", Dimension::kAngularVelocity, kDegree},
    {"\xB0/s", Dimension::kAngularVelocity, kDegree},  // Latin-1, as in most DBC files
    {"°/s", Dimension::kAngularVelocity, kDegree},
    {"rad", Dimension::kAngle, 1},
    {"deg", Dimension::kAngle, kDegree},
    {"\xB0", Dimension::kAngle, kDegree},
    {"°", Dimension::kAngle, kDegree},
    {"m/s^2", Dimension::kAcceleration, 1},
    {"m/s2", Dimension::kAcceleration, 1},
    {"m/s\xB2", Dimension::kAcceleration, 1},
    {"m/s²", Dimension::kAcceleration, 1},
    {"g", Dimension::kAcceleration, 9.80665},
};

const char* unit_hint(Dimension dimension) {
  switch (dimension) {
    case Dimension::kSpeed:
      return "set `unit` to m/s, km/h or mph";
    case Dimension::kAngularVelocity:
      return "set `unit` to rad/s or deg/s";
    case Dimension::kAngle:
      return "set `unit` to rad or deg";
    case Dimension::kAcceleration:
      return "set `unit` to m/s^2 or g";
    case Dimension::kNone:
      break;
  }
  return "";
}

bool is_set(const SignalSource& source) { return !source.signal.empty(); }

}  // namespace

std::optional<std::string> SignalMap::invalid() const {
  const auto wrong = [](const SignalSource& source) -> std::optional<std::string> {
    if (!is_set(source)) return std::nullopt;
    if (source.signal.find('.') == std::string::npos) {
      return "'" + source.signal + "' must be MESSAGE.SIGNAL";
    }
    if (!std::isfinite(source.scale) || source.scale == 0) {
      return "the scale of " + source.signal + " must be finite and not 0";
    }
    return std::nullopt;
  };
  bool any = false;
  const auto check = [&](const SignalSource& source) {
    any = any || is_set(source);
    return wrong(source);
  };
  for (const SignalSource& source : wheel_speed) {
    if (auto message = check(source)) return message;
  }
  for (const SignalSource& source : acceleration) {
    if (auto message = check(source)) return message;
  }
  for (const SignalSource& source : angular_velocity) {
    if (auto message = check(source)) return message;
  }
  for (const SignalSource* source : {&speed, &yaw_rate, &steering_angle}) {
    if (auto message = check(*source)) return message;
  }
  if (!any) return "no signal is configured";
  for (const SignalSource* source : {&steering_fraction, &gear}) {
    if (auto message = wrong(*source)) return message;
  }
  if (is_set(steering_fraction) && !is_set(steering_angle)) {
    return "steering_fraction needs steering_angle";
  }
  if (std::isfinite(reverse_gear) && !is_set(gear)) return "reverse_gear needs gear";
  return std::nullopt;
}

Result<VehicleDecoder> VehicleDecoder::create(const Dbc& dbc, const SignalMap& map) {
  if (const auto wrong = map.invalid()) return fail(*wrong, "signal map");
  VehicleDecoder decoder;
  decoder.interface_ = map.interface;
  decoder.reverse_gear_ = map.reverse_gear;
  std::vector<std::pair<const SignalSource*, Quantity>> wanted = {
      {&map.speed, kSpeed},
      {&map.yaw_rate, kYawRate},
      {&map.steering_angle, kSteeringAngle},
      {&map.steering_fraction, kSteeringFraction},
      {&map.gear, kGear}};
  for (size_t i = 0; i < 4; ++i) {
    wanted.emplace_back(&map.wheel_speed[i], static_cast<Quantity>(kWheelSpeed + i));
  }
  for (size_t i = 0; i < 3; ++i) {
    wanted.emplace_back(&map.acceleration[i], static_cast<Quantity>(kAcceleration + i));
    wanted.emplace_back(&map.angular_velocity[i], static_cast<Quantity>(kAngularVelocity + i));
  }
  for (const auto& [source, quantity] : wanted) {
    if (!is_set(*source)) continue;
    if (auto error = decoder.bind(dbc, *source, quantity)) return tl::unexpected(*error);
  }
  return decoder;
}

std::optional<Error> VehicleDecoder::bind(const Dbc& dbc, const SignalSource& source,
                                          Quantity quantity) {
  const size_t dot = source.signal.find('.');
  const DbcMessage* message = dbc.find(std::string_view(source.signal).substr(0, dot));
  const DbcSignal* signal =
      message == nullptr ? nullptr
                         : message->find_signal(std::string_view(source.signal).substr(dot + 1));
  if (signal == nullptr) {
    return Error{"the DBC has no signal " + source.signal, "signal map",
                 message == nullptr ? "it has no message of that name"
                                    : "the message exists; check the signal's name"};
  }
  const Dimension dimension = quantity < kYawRate             ? Dimension::kSpeed
                              : quantity == kYawRate          ? Dimension::kAngularVelocity
                              : quantity <= kSteeringFraction ? Dimension::kAngle
                              : quantity < kAngularVelocity   ? Dimension::kAcceleration
                              : quantity < kGear              ? Dimension::kAngularVelocity
                                                              : Dimension::kNone;
  double factor = source.scale;
  if (dimension != Dimension::kNone) {
    const std::string& unit = source.unit.empty() ? signal->unit : source.unit;
    const Unit* known = std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit& u) {
      return u.name == unit && u.dimension == dimension;
    });
    if (known == std::end(kUnits)) {
      return Error{"unit '" + unit + "' of " + source.signal + " does not fit", "signal map",
                   unit_hint(dimension)};
    }
    factor *= known->factor;
  }
  auto bound = std::find_if(messages_.begin(), messages_.end(), [&](const BoundMessage& b) {
    return b.message.id == message->id && b.message.extended == message->extended;
  });
  if (bound == messages_.end()) bound = messages_.insert(bound, BoundMessage{*message, {}});
  bound->bindings.push_back(
      {static_cast<size_t>(signal - message->signals.data()), factor, quantity});
  return std::nullopt;
}

VehicleSamples VehicleDecoder::decode(const CanFrame& frame) {
  if (frame.error || frame.remote) return {};
  if (!interface_.empty() && frame.interface_name() != interface_) return {};
  const auto bound = std::find_if(messages_.begin(), messages_.end(), [&](const BoundMessage& b) {
    return b.message.id == frame.id && b.message.extended == frame.extended;
  });
  if (bound == messages_.end()) return {};
  Values values;
  values.fill(kNaN);
  for (const Binding& binding : bound->bindings) {
    const DbcSignal& signal = bound->message.signals[binding.signal];
    if (const auto value = vehicle::decode(bound->message, signal, frame.payload())) {
      values[binding.quantity] = *value * binding.factor;
    }
  }
  if (std::isfinite(values[kGear])) reversing_ = values[kGear] == reverse_gear_;
  return make_samples(values, frame.stamp);
}

VehicleSamples VehicleDecoder::make_samples(const Values& values, Stamp stamp) const {
  const auto any = [&](int from, int to) {
    return std::any_of(values.begin() + from, values.begin() + to,
                       [](double v) { return std::isfinite(v); });
  };
  VehicleSamples samples;
  if (any(kWheelSpeed, kSteeringFraction)) {
    WheelOdometry wheels;
    wheels.stamp = stamp;
    for (size_t i = 0; i < 4; ++i) {
      wheels.wheel_speed[i] = reversing_ ? -values[kWheelSpeed + i] : values[kWheelSpeed + i];
    }
    wheels.speed = reversing_ ? -values[kSpeed] : values[kSpeed];
    wheels.yaw_rate = values[kYawRate];
    const double fraction = values[kSteeringFraction];
    wheels.steering_angle = values[kSteeringAngle] + (std::isfinite(fraction) ? fraction : 0);
    samples.wheels = wheels;
  }
  if (any(kAcceleration, kGear)) {
    ImuSample imu;
    imu.stamp = stamp;
    for (size_t i = 0; i < 3; ++i) {
      imu.linear_acceleration[i] = values[kAcceleration + i];
      imu.angular_velocity[i] = values[kAngularVelocity + i];
    }
    samples.imu = imu;
  }
  return samples;
}

bool VehicleDecoder::has_gyros() const {
  std::array<bool, 3> axes{};
  for (const BoundMessage& bound : messages_) {
    for (const Binding& binding : bound.bindings) {
      if (binding.quantity >= kAngularVelocity && binding.quantity < kAngularVelocity + 3)
        axes[static_cast<size_t>(binding.quantity - kAngularVelocity)] = true;
    }
  }
  return axes[0] && axes[1] && axes[2];
}

std::vector<CanIdentifier> VehicleDecoder::identifiers() const {
  std::vector<CanIdentifier> identifiers;
  for (const BoundMessage& bound : messages_) {
    identifiers.push_back({bound.message.id, bound.message.extended});
  }
  return identifiers;
}

}  // namespace infuse::vehicle
