#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/lidar/decoder_options.hpp"
#include "drivers/lidar/lidar_decoder.hpp"
#include "drivers/lidar/lidar_model.hpp"
#include "drivers/lidar/model_inference.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/vehicle_samples.hpp"

namespace infuse::lidar {

/// Kind of a datagram of a lidar.
enum class PacketClass : uint8_t {
  kData,         ///< returns
  kInformation,  ///< clock, sentences of a GNSS receiver, the unit's calibration
  kInertial,     ///< samples of an inertial unit
  kOther,        ///< of no packet of this maker
};

/// UDP ports to which a maker's lidars send as they come from the factory.
struct LidarPorts {
  uint16_t data = 2368;         ///< of returns
  uint16_t information = 8308;  ///< equal to `data`: none
};

/// Message in which ROS drivers publish a maker's data packets.
enum class RosPackets : uint8_t {
  kNone,           ///< none that is known here: sweeps are published instead
  kVelodyneScan,   ///< velodyne_msgs/VelodyneScan: the packets of a turn, 1206 bytes each
  kPandarScan,     ///< pandar_msgs/PandarScan: the packets of a turn
  kRslidarPacket,  ///< rslidar_msg/RslidarPacket: a packet of any kind
  kOusterPacket,   ///< ouster_sensor_msgs/PacketMsg: a packet; inertial ones on another topic
};

/// A packet at the beginning of bytes that may hold anything.
struct FoundPacket {
  PacketClass packet_class = PacketClass::kOther;  ///< its kind
  size_t size = 0;                                 ///< bytes
  bool certain = false;  ///< false: a message must state its length before it
};

/// A model that a unit's calibration states.
struct StatedModel {
  const LidarModel* model = nullptr;  ///< the model
  std::filesystem::path calibration;  ///< the file, or what else names it
  std::string states;                 ///< what it states of firmware, modes and clock, for people
};

/// What a data packet states of its sensor.
struct StatedPacket {
  const LidarModel* model = nullptr;  ///< null: one that is not known
  Duration counter{0};                ///< device time of the first firing, which never wraps
  int azimuth = 0;                    ///< 0.01°, of the first firing
};

/// A maker of lidars: what its packets are. One object for each maker, in the list of
/// `drivers/makers`, by which alone the program knows it; nothing changes it.
class LidarMaker {
 public:
  LidarMaker(const LidarMaker&) = delete;
  LidarMaker& operator=(const LidarMaker&) = delete;
  virtual ~LidarMaker() = default;

  /// "Velodyne".
  const char* name() const { return name_; }

  /// The models, whose address never changes.
  std::span<const LidarModel> models() const { return models_; }

  /// Place of a model in the list.
  size_t index_of(const LidarModel& model) const {
    return static_cast<size_t>(&model - models_.data());
  }

  /// Ports as they come from the factory.
  LidarPorts ports() const { return ports_; }

  /// Kind of a datagram's payload, by its size and first bytes: fast, and never wrong for packets
  /// of this maker.
  virtual PacketClass classify(std::span<const uint8_t> payload) const = 0;

  /// What a data packet states; nothing if the payload is none, or if packets of this maker state
  /// no model.
  virtual std::optional<StatedPacket> read_stated(std::span<const uint8_t> payload) const;

  /// What a packet of any kind states of its sensor's firmware, mode and clock, for people:
  /// "protocol 6.1, strongest return". Empty: nothing.
  virtual std::string describe(std::span<const uint8_t> payload) const;

  /// An object that infers the model from data packets; by default from what they state.
  virtual std::unique_ptr<ModelInference> make_inference() const;

  /// Makes a decoder. The options are valid, and their calibration is of their model: see
  /// `make_decoder`. Errors: the model needs a calibration.
  virtual Result<std::unique_ptr<LidarDecoder>> new_decoder(
      const DecoderOptions& options) const = 0;

  /// Reads the calibration of a unit of this model from a file.
  virtual Result<std::shared_ptr<const UnitCalibration>> load_calibration(
      const LidarModel& model, const std::filesystem::path& file) const;

  /// What the maker calls such a file.
  virtual const char* calibration_file() const { return "calibration file"; }

  /// For makers whose packets state no model, but whose units' calibration does: the calibration of
  /// the sensor that sent these packets of a capture, as `stated` names it; if that is empty, the
  /// one stored beside the capture. Nothing: the packets state the model. Errors: there is none, or
  /// it cannot be read.
  virtual Result<std::optional<StatedModel>> find_calibration(const std::filesystem::path& capture,
                                                              const std::filesystem::path& stated,
                                                              const ModelInference& packets) const;

  /// Bytes of the longest payload of a datagram.
  virtual size_t max_datagram() const { return 2048; }

  /// The fix of a GNSS receiver in an information packet, with the datagram's stamp, also if
  /// earlier packets held it already.
  virtual std::optional<GnssFix> read_fix(const Datagram& datagram) const;

  /// Azimuth at which a data packet begins, 0.01°, clockwise; by default as it states it.
  virtual uint16_t first_azimuth(std::span<const uint8_t> payload) const;

  /// Message in which ROS drivers publish the data packets.
  virtual RosPackets ros_packets() const { return RosPackets::kNone; }

  /// The packet of this maker with which these bytes begin, by its content: for messages of unknown
  /// type. Nothing if they begin with something else.
  virtual std::optional<FoundPacket> find_packet(std::span<const uint8_t> bytes) const;

  /// The data packet `index` of a sensor that turns ten times a second in the middle of a cylinder
  /// of this radius, m: for the self-test of a release. Empty: there is none.
  virtual std::vector<uint8_t> example_packet(const LidarModel& model, uint32_t index,
                                              double radius) const;

  /// Time from one such packet to the next.
  virtual Duration example_period(const LidarModel& model) const;

 protected:
  /// The models need not name their maker.
  LidarMaker(const char* name, LidarPorts ports, std::vector<LidarModel> models);

 private:
  const char* name_;
  LidarPorts ports_;
  std::vector<LidarModel> models_;
};

/// A list of makers. Where packets of two are alike, the first one's `classify` decides.
using MakerList = std::span<const LidarMaker* const>;

/// Finds a model by name among those of all makers; only letters and digits count, case does not
/// ("vlp16", "VLP-16"). Null if there is none.
const LidarModel* find_model(MakerList makers, std::string_view name);

/// A datagram's maker and kind; no maker: `kOther`.
struct ClassifiedPacket {
  const LidarMaker* maker = nullptr;               ///< null: none
  PacketClass packet_class = PacketClass::kOther;  ///< its kind
};

/// Kind of a datagram's payload, by the first maker that knows it.
ClassifiedPacket classify(MakerList makers, std::span<const uint8_t> payload);

/// Makes a decoder of the options' model, which must be set. Errors: invalid options, a calibration
/// that the model needs or that is not its own.
Result<std::unique_ptr<LidarDecoder>> make_decoder(const DecoderOptions& options);

}  // namespace infuse::lidar
