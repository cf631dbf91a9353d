#pragma once

#include <cstdint>
#include <memory>

#include "drivers/lidar/lidar_decoder.hpp"
#include "drivers/velodyne/beam_table.hpp"
#include "drivers/velodyne/calibration.hpp"
#include "drivers/velodyne/calibration_stream.hpp"
#include "drivers/velodyne/firing_cycle_estimator.hpp"
#include "drivers/velodyne/model.hpp"
#include "drivers/velodyne/return_kernel.hpp"

namespace infuse::velodyne {

/// Decodes the packets of one Velodyne. What only the stream holds is read from it: an HDL-64E's
/// calibration, a VLS-128's firing cycle.
class Decoder final : public lidar::LidarDecoder {
 public:
  /// The options must be valid; model and calibration must be of this maker.
  explicit Decoder(const lidar::DecoderOptions& options);

  /// The calibration in use.
  const Calibration& calibration() const { return calibration_; }

  /// Firing cycle in use: the model's, or the observed one if firmware determines it.
  Duration firing_cycle() const { return table_.cycle; }

  std::shared_ptr<const lidar::UnitCalibration> streamed_calibration() const override;

 private:
  const char* parse(std::span<const uint8_t> payload, lidar::PacketHeader& header) const override;
  const char* read_information(const Datagram& datagram) override;
  void observe(std::span<const uint8_t> payload, const lidar::PacketHeader& header,
               const lidar::ArrivalOrder::Verdict& verdict) override;
  void forget_unit() override;
  void append(const lidar::HeldPacket& packet, const lidar::FiringPlan& plan, size_t first,
              size_t last, lidar::SweepWriter& writer) override;

  const ModelInfo& info_;
  Calibration calibration_;
  BeamTable table_;
  CalibrationStream calibration_stream_;
  FiringCycleEstimator cycle_estimator_;
  ReturnKernel kernel_;
  bool interpolate_;
  uint64_t agreeing_sentences_ = 0;  ///< position packets in a row that count from the hour
  int64_t last_sentence_ns_ = 0;     ///< UTC of the latest sentence
};

}  // namespace infuse::velodyne
