#include "packaging/python/player.hpp"

#include "daemon/pipeline/odometry_plan.hpp"
#include "daemon/playback/read_image.hpp"
#include "packaging/python/sweep_memory.hpp"

namespace infuse::python {

Player::Player(daemon::SensorSetup setup, const PlayerOptions& options)
    : setup_(std::move(setup)), options_(options), vehicle_(setup_.vehicle) {
  for (const daemon::LidarSetup& lidar : setup_.lidars) lidars_.emplace_back(lidar);
  if (!options_.deskew) return;
  const size_t lidar = options_.lidar.value();
  deskewed_.emplace(daemon::plan_odometry({}, setup_, lidar), setup_.lidars[lidar].T_vehicle_lidar);
}

Result<std::optional<Player::Item>> Player::next() {
  recording::DriveEvent event;
  while (items_.empty() && !ended_) {
    if (!setup_.source.next(event)) {
      ended_ = true;
      finish();
    } else if (auto processed = process(event); !processed) {
      return tl::unexpected(processed.error());
    }
  }
  if (items_.empty()) return std::nullopt;
  Item item = std::move(items_.front());
  items_.pop_front();
  return item;
}

Result<void> Player::process(const recording::DriveEvent& event) {
  Result<void> result;
  if (const auto* datagram = std::get_if<recording::DatagramEvent>(&event.content)) {
    process(*datagram);
  } else if (const auto* sweep = std::get_if<recording::SweepEvent>(&event.content)) {
    add_sweep(sweep->lidar, *sweep->sweep);
  } else if (const auto* image = std::get_if<recording::ImageEvent>(&event.content)) {
    result = process(*image, event.stamp);
  } else if (const auto* bus = std::get_if<recording::CanLineEvent>(&event.content)) {
    vehicle_.add_can_line(bus->line, event.stamp,
                          [this](const daemon::VehicleSample& sample) { add_sample(sample); });
  } else if (const auto* speed = std::get_if<WheelOdometry>(&event.content)) {
    add_sample(*speed);
  } else if (const auto* imu = std::get_if<ImuSample>(&event.content)) {
    add_sample(*imu);
  } else if (const auto* fix = std::get_if<GnssFix>(&event.content)) {
    add_sample(*fix);
  }
  if (deskewed_) {
    deskewed_->process_due(event.stamp,
                           [this](const Sweep& raw, const motion::DeskewedSweep& deskewed) {
                             add_deskewed(raw, deskewed);
                           });
  }
  return result;
}

void Player::process(const recording::DatagramEvent& event) {
  const size_t lidar = event.lidar;
  if (lidar == recording::kNoLidar) return;
  // Position packets of a lidar that is not wanted are read for their fixes.
  const bool has_fixes = options_.samples || options_.deskew;
  if (!has_fixes && (!options_.sweeps || lidar != options_.lidar.value_or(lidar))) return;
  lidars_[lidar].add_datagram(
      event.datagram, [&](const Sweep& sweep) { add_sweep(lidar, sweep); },
      [&](const GnssFix& fix) {
        if (setup_.gnss_lidar == lidar) add_sample(fix);
      },
      [&](const GyroReadings& readings) {
        if (lidar == options_.lidar.value_or(0)) add_sample(readings);
      },
      [&](const ImuSample& sample) {
        if (lidar == options_.lidar.value_or(0) && !vehicle_.has_inertial_unit()) {
          add_sample(sample);
        }
      });
}

Result<void> Player::process(const recording::ImageEvent& event, Stamp stamp) {
  if (!options_.images || event.camera != options_.camera.value_or(event.camera)) return {};
  auto frame = daemon::read_image(*event.path, setup_.cameras[event.camera].image);
  if (!frame) return tl::unexpected(frame.error());
  frame->stamp = stamp;
  frame->sequence = event.sequence;
  items_.emplace_back(setup_.cameras[event.camera].device.name, std::move(*frame));
  return {};
}

void Player::add_sweep(size_t lidar, const Sweep& sweep) {
  if (!options_.sweeps || lidar != options_.lidar.value_or(lidar)) return;
  if (deskewed_) {
    deskewed_->add_sweep(sweep);
  } else {
    Sweep copy = recycled_sweep();
    copy = sweep;
    items_.emplace_back(setup_.lidars[lidar].device.name, std::move(copy));
  }
}

void Player::add_sample(const daemon::VehicleSample& sample) {
  if (deskewed_) deskewed_->add_sample(sample);
  if (!options_.samples) return;
  std::visit([this](const auto& value) { items_.emplace_back("vehicle", value); }, sample);
}

void Player::add_deskewed(const Sweep& sweep, const motion::DeskewedSweep& deskewed) {
  Sweep out = recycled_sweep();
  out = sweep;
  if (deskewed.usable()) {
    out.x = deskewed.x, out.y = deskewed.y, out.z = deskewed.z;
    out.deskewed = true;
    const auto offset = static_cast<int32_t>((deskewed.reference - sweep.stamp).count());
    std::fill(out.time_offset_ns.begin(), out.time_offset_ns.end(), offset);
  }
  items_.emplace_back(setup_.lidars[options_.lidar.value_or(0)].device.name, std::move(out));
}

void Player::finish() {
  for (size_t lidar = 0; lidar < lidars_.size(); ++lidar) {
    lidars_[lidar].finish([&](const Sweep& sweep) { add_sweep(lidar, sweep); });
  }
  if (!deskewed_) return;
  deskewed_->finish([this](const Sweep& raw, const motion::DeskewedSweep& deskewed) {
    add_deskewed(raw, deskewed);
  });
}

}  // namespace infuse::python
