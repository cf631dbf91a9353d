#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/vehicle/dbc.hpp"

namespace infuse::vehicle {

/// The signal that carries a quantity.
struct SignalSource {
  std::string signal;  ///< "MESSAGE.SIGNAL" as in the DBC; empty: the vehicle has none
  double scale = 1;    ///< multiplies the SI value; −1 if the bus uses the opposite sign
  std::string unit{};  ///< the signal's unit, if the DBC's is missing or wrong; empty: the DBC's
};

/// The signals of a bus that are the vehicle's odometry. Units come from the DBC and are converted.
struct SignalMap {
  std::string interface;                     ///< only frames of this interface are used; empty: all
  std::array<SignalSource, 4> wheel_speed;   ///< front left, front right, rear left, rear right
  SignalSource speed;                        ///< of the vehicle, as OBD-II has it
  SignalSource yaw_rate;                     ///< counter-clockwise seen from above
  SignalSource steering_angle;               ///< at the steering wheel, left positive
  SignalSource steering_fraction;            ///< finer digits, added to the steering angle
  std::array<SignalSource, 3> acceleration;  ///< forward, left, up
  std::array<SignalSource, 3> angular_velocity;  ///< about forward, left, up
  SignalSource gear;
  /// Value of `gear` in which speeds count backwards; NaN: they carry their sign.
  double reverse_gear = std::numeric_limits<double>::quiet_NaN();

  /// Returns what is wrong with the map alone, or nothing.
  std::optional<std::string> invalid() const;
};

/// Samples of one frame; both may be set, or neither.
struct VehicleSamples {
  std::optional<WheelOdometry> wheels;
  std::optional<ImuSample> imu;
};

/// Decodes CAN frames into samples. Quantities that a frame does not carry are NaN in its sample.
class VehicleDecoder {
 public:
  /// Links the map to a DBC. Fails, naming the signal, if the DBC lacks it or its unit does not fit
  /// the quantity.
  static Result<VehicleDecoder> create(const Dbc& dbc, const SignalMap& map);

  /// The samples of one frame.
  VehicleSamples decode(const CanFrame& frame);

  /// True if the bus carries the angular velocity about all three axes.
  bool has_gyros() const;

  /// Identifiers of the decoded messages.
  std::vector<CanIdentifier> identifiers() const;

 private:
  /// Index of a decoded value in `Values`.
  enum Quantity : uint8_t {
    kWheelSpeed = 0,
    kSpeed = 4,
    kYawRate,
    kSteeringAngle,
    kSteeringFraction,
    kAcceleration,
    kAngularVelocity = kAcceleration + 3,
    kGear = kAngularVelocity + 3,
    kQuantityCount,
  };
  using Values = std::array<double, kQuantityCount>;

  struct Binding {
    size_t signal = 0;  ///< index in the message
    double factor = 1;
    Quantity quantity = kWheelSpeed;
  };
  struct BoundMessage {
    DbcMessage message;
    std::vector<Binding> bindings;
  };

  std::optional<Error> bind(const Dbc& dbc, const SignalSource& source, Quantity quantity);
  VehicleSamples make_samples(const Values& values, Stamp stamp) const;

  std::string interface_;
  std::vector<BoundMessage> messages_;
  double reverse_gear_ = std::numeric_limits<double>::quiet_NaN();
  bool reversing_ = false;
};

}  // namespace infuse::vehicle
