#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace infuse::lidar {

struct LidarModel;

/// A model and the reason for it.
struct InferredModel {
  const LidarModel* model = nullptr;
  std::string reason;  ///< "packets 1327 us apart are a VLP-16's, though product byte 0x21 says …"
};

/// Infers the model of a sensor from its data packets, by majority. Allocates nothing but texts.
class ModelInference {
 public:
  virtual ~ModelInference() = default;

  /// Adds the payload of a data packet; other payloads are ignored.
  virtual void add(std::span<const uint8_t> payload) = 0;

  /// The model of the packets so far; null while there are too few, or if no model fits them.
  virtual const LidarModel* judge() const = 0;

  /// The same with the reason.
  virtual std::optional<InferredModel> infer() const = 0;

  /// What is known of the packets: "product byte 0x99, packets 553 us apart".
  virtual std::string describe() const = 0;

  /// Number of data packets seen, and number from which a model is inferred.
  virtual uint64_t packets() const = 0;
  virtual uint64_t min_packets() const = 0;

  /// Turns per second by azimuth over the device's time, whatever the model; 0 while unknown.
  virtual double turns_per_second() const = 0;

  /// True if packets of two sensors alternate.
  virtual bool has_two_sensors() const = 0;
};

}  // namespace infuse::lidar
