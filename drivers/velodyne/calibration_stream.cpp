#include "drivers/velodyne/calibration_stream.hpp"

#include <string_view>

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {
namespace {

constexpr std::string_view kMarkerText = "UNIT#";
constexpr std::string_view kStatusTypes = "HMSDNYGTV";
constexpr size_t kFirstRecordOffset = 7;
constexpr size_t kRecordStride = 28;
constexpr size_t kRecordSize = 21;
constexpr size_t kLasers = 64;

/// CRC-16, polynomial 0x8005, not reflected.
uint16_t crc16(uint16_t crc, uint8_t byte) {
  uint32_t shifted = crc ^ static_cast<uint32_t>(byte << 8);
  for (int bit = 0; bit < 8; ++bit) {
    shifted <<= 1;
    if ((shifted & 0x10000) != 0) shifted ^= 0x18005;
  }
  return static_cast<uint16_t>(shifted);
}

BeamCorrection read_record(const std::array<uint8_t, kRecordSize>& record) {
  constexpr double kMillimetre = 0.001;
  const auto word = [&](size_t i) {
    return static_cast<double>(static_cast<int16_t>(record[1 + 2 * i] | record[2 + 2 * i] << 8));
  };
  BeamCorrection beam;
  beam.elevation = word(0) * kCentidegree;
  beam.rotation = word(1) * kCentidegree;
  beam.distance = word(2) * kMillimetre;
  beam.distance_x = word(3) * kMillimetre;
  beam.distance_y = word(4) * kMillimetre;
  beam.vertical_offset = word(5) * kMillimetre;
  beam.horizontal_offset = word(6) * kMillimetre;
  beam.focal_distance = word(7) * kMillimetre;
  beam.focal_slope = word(8) * 0.1;
  beam.min_intensity = record[19];
  beam.max_intensity = record[20];
  return beam;
}

}  // namespace

std::optional<Calibration> CalibrationStream::add(uint8_t type, uint8_t value) {
  if (kStatusTypes.find(static_cast<char>(type)) != std::string_view::npos) return std::nullopt;
  with_warnings_.push(value);
  if (type != 'W') without_warnings_.push(value);
  for (Window* window : {&with_warnings_, &without_warnings_}) {
    if (!window->has_cycle()) continue;
    if (auto calibration = read(*window)) return calibration;
  }
  return std::nullopt;
}

void CalibrationStream::restart() {
  with_warnings_.clear();
  without_warnings_.clear();
}

std::optional<Calibration> CalibrationStream::read(const Window& window) const {
  Calibration calibration;
  uint16_t crc = 0;
  for (size_t laser = 0; laser < kLasers; ++laser) {
    std::array<uint8_t, kRecordSize> record;
    for (size_t i = 0; i < kRecordSize; ++i) {
      record[i] = window.at(kFirstRecordOffset + laser * kRecordStride + i);
      if (i > 0) crc = crc16(crc, record[i]);
    }
    if (record[0] != laser) return std::nullopt;
    calibration.beams[laser] = read_record(record);
  }
  const auto stated =
      static_cast<uint16_t>(window.at(kCycleBytes - 2) | window.at(kCycleBytes - 1) << 8);
  if (model_ == Model::kHdl64eS3 && stated != crc) return std::nullopt;
  if (calibration.invalid(model_info(model_))) return std::nullopt;
  return calibration;
}

void CalibrationStream::Window::push(uint8_t byte) {
  bytes_[next_] = byte;
  next_ = (next_ + 1) % bytes_.size();
  ++count_;
}

bool CalibrationStream::Window::has_cycle() const {
  return count_ >= bytes_.size() && marker_at(kCycleBytes) && marker_at(0);
}

bool CalibrationStream::Window::marker_at(size_t i) const {
  for (size_t k = 0; k < kMarkerBytes; ++k) {
    if (at(i + k) != static_cast<uint8_t>(kMarkerText[k])) return false;
  }
  return true;
}

}  // namespace infuse::velodyne
