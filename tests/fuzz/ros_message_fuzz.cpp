#include <cstdlib>
#include <tuple>

#include "drivers/import/bag_cloud.hpp"
#include "drivers/ros/messages.hpp"
#include "drivers/ros/serialisation.hpp"

namespace {

using namespace infuse;

using Types = std::tuple<ros::PointCloud2, ros::Image, ros::CompressedImage, ros::CameraInfo,
                         ros::TfMessage, ros::VelodyneScan, ros::Imu, ros::NavSatFix, ros::Odometry,
                         ros::TwistStamped, ros::UInt8MultiArray, ros::DiagnosticArray,
                         ros::TwistWithCovarianceStamped, ros::PandarScan, ros::NebulaPackets,
                         ros::RslidarPacket, ros::OldRslidarScan, ros::OusterPacket, ros::String>;

/// What is decoded is the same after being encoded and decoded again.
template <class T>
void read(std::span<const uint8_t> bytes, ros::Encoding encoding) {
  const auto message = ros::decode<T>(bytes, encoding);
  if (!message) return;
  std::vector<uint8_t> once, twice;
  ros::encode(*message, encoding, once);
  const auto again = ros::decode<T>(once, encoding);
  if (!again) std::abort();
  ros::encode(*again, encoding, twice);
  if (once != twice) std::abort();
  if constexpr (std::is_same_v<T, ros::PointCloud2>) {
    Sweep sweep;
    if (importers::to_sweep(*message, Stamp(), sweep) && sweep.size() != sweep.ring.size())
      std::abort();
  }
}

template <size_t... Indices>
void read_as(size_t type, std::span<const uint8_t> bytes, ros::Encoding encoding,
             std::index_sequence<Indices...>) {
  ((type == Indices ? read<std::tuple_element_t<Indices, Types>>(bytes, encoding) : void()), ...);
}

}  // namespace

// The first byte selects the type and the encoding of the message in the rest.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  constexpr size_t kTypes = std::tuple_size_v<Types>;
  const auto encoding = data[0] < 128 ? ros::Encoding::kCdr : ros::Encoding::kRos1;
  read_as(data[0] % 128 % kTypes, {data + 1, size - 1}, encoding,
          std::make_index_sequence<kTypes>());
  return 0;
}
