#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/vehicle/dbc.hpp"

namespace infuse::vehicle {

/// The signal that says a quantity.
struct SignalSource {
  std::string signal;  ///< "MESSAGE.SIGNAL" as the DBC names them; empty: the vehicle has none
  double scale = 1;    ///< multiplies the SI value; −1 where the bus counts the other way
  std::string unit{};  ///< the signal's unit where the DBC's is missing or wrong; empty: the DBC's
};

/// Which signals of a bus are the vehicle's odometry. Units are taken from the DBC and converted.
struct SignalMap {
  std::string interface;  ///< frames of other interfaces are passed over; empty: all are read
  std::array<SignalSource, 4> wheel_speed;       ///< front left, front right, rear left, rear right
  SignalSource yaw_rate;                         ///< counter-clockwise seen from above
  SignalSource steering_angle;                   ///< at the steering wheel, left positive
  SignalSource steering_fraction;                ///< finer digits, added to the steering angle
  std::array<SignalSource, 3> acceleration;      ///< forward, left, up
  std::array<SignalSource, 3> angular_velocity;  ///< about forward, left, up
  SignalSource gear;
  double reverse_gear = std::numeric_limits<double>::quiet_NaN();  ///< value of `gear` in which
                                                                   ///< wheel speeds count backward;
                                                                   ///< NaN: they carry their sign

  /// What is wrong with the map by itself, or nothing.
  std::optional<std::string> invalid() const;
};

/// What one frame says; a frame may say both or nothing.
struct VehicleSamples {
  std::optional<WheelOdometry> wheels;
  std::optional<ImuSample> imu;
};

/// Turns CAN frames into samples. What a frame does not carry is NaN in its sample.
class VehicleDecoder {
 public:
  /// Ties the map to a DBC. Fails, naming the signal, where the DBC has no such signal or its unit
  /// is none of the quantity's.
  static Result<VehicleDecoder> create(const Dbc& dbc, const SignalMap& map);

  /// The samples of one frame.
  VehicleSamples decode(const CanFrame& frame);

  /// The messages that are decoded.
  std::vector<CanIdentifier> identifiers() const;

  /// Frames that were too short for a signal in them.
  uint64_t short_frames() const { return short_frames_; }

 private:
  /// Where a decoded value goes: an index into `Values`.
  enum Quantity : uint8_t {
    kWheelSpeed = 0,
    kYawRate = 4,
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
  uint64_t short_frames_ = 0;
};

}  // namespace infuse::vehicle
