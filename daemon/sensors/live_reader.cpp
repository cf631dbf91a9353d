#include "daemon/sensors/live_reader.hpp"

#include <utility>

namespace infuse::daemon {
namespace {

constexpr int kPollTimeoutMs = 10;  // upper bound of the delay of ticks, stops and due samples
constexpr Duration kMaintenancePeriod{100'000'000};
constexpr int kMaxBatchesPerRead = 4;  // from one socket, before the others are read

}  // namespace

LiveReader::LiveReader(const SensorSetup& setup, Intake& intake, const host::TimeBase& base,
                       RecordTap* tap)
    : base_(base), intake_(intake), tap_(tap), gnss_lidar_(setup.gnss_lidar) {
  std::vector<std::filesystem::path> devices;
  for (const PortSetup& port : setup.ports) {
    ports_.push_back({port, {"UDP port " + std::to_string(port.udp.port), [this, udp = port.udp] {
                               return lidar::UdpSource::open(udp, base_);
                             }}});
  }
  for (size_t i = 0; i < setup.cameras.size(); ++i) {
    const camera::V4l2Options& stream = setup.cameras[i].stream;
    Camera& camera = cameras_.emplace_back(Camera{{"camera " + stream.device, [this, stream] {
                                                     return camera::V4l2Source::open(stream, base_);
                                                   }}});
    camera.used = setup.is_mounted(CameraIndex(i));
    devices.emplace_back(stream.device);
  }
  for (const BusSetup& setup_of_bus : setup.vehicle.buses) {
    const vehicle::SocketCanOptions& socket = setup_of_bus.interface;
    Bus& bus = buses_.emplace_back(Bus{{"CAN bus " + socket.interface, [this, socket] {
                                          return vehicle::SocketCanSource::open(socket, base_);
                                        }}});
    bus.used = setup_of_bus.decoder.has_value();
  }
  if (setup.gnss_serial) {
    gnss_.emplace("GNSS receiver " + setup.gnss_serial->device,
                  [this, serial = *setup.gnss_serial] {
                    return vehicle::SerialLineSource::open(serial, base_);
                  });
    devices.emplace_back(setup.gnss_serial->device);
  }
  devices_.emplace(devices);
  intake_.sources() = SourceStates(setup);
}

void LiveReader::run(std::stop_token stop) {
  intake_.start(base_.now());
  while (!stop.stop_requested()) {
    Stamp now = base_.now();
    if (now - last_maintenance_ >= kMaintenancePeriod) {
      last_maintenance_ = now;
      reopen_sources(now);
      update_source_states();
      rebuild_poll_set();
    }
    const int ready = poll(poll_set_.data(), poll_set_.size(), kPollTimeoutMs);
    now = base_.now();
    intake_.advance(now);
    if (ready > 0) read_ready_sources();
    intake_.push_due_samples(now);
    if (tap_ != nullptr) tap_->flush_if_due(now);
  }
  intake_.end(base_.now());
}

void LiveReader::reopen_sources(Stamp now) {
  for (Port& port : ports_) {
    if (port.source.reopen_if_due(now)) port.reported_dropped = 0;
    // An interface that was recreated is no longer a member of the multicast group.
    if (port.source.get() != nullptr && port.datagrams == port.datagrams_before) {
      port.source.get()->rejoin();
    }
    port.datagrams_before = port.datagrams;
  }
  for (Camera& camera : cameras_) {
    if (camera.source.reopen_if_due(now)) camera.sequence_offset = camera.next_sequence;
  }
  for (Bus& bus : buses_) bus.source.reopen_if_due(now);
  if (gnss_) gnss_->reopen_if_due(now);
}

/// A closed source has the descriptor −1, which poll() ignores.
void LiveReader::rebuild_poll_set() {
  poll_set_.clear();
  const auto add_to_poll_set = [&](auto* source) {
    poll_set_.push_back({source != nullptr ? source->descriptor() : -1, POLLIN, 0});
  };
  for (Port& port : ports_) add_to_poll_set(port.source.get());
  for (Camera& camera : cameras_) add_to_poll_set(camera.source.get());
  for (Bus& bus : buses_) add_to_poll_set(bus.source.get());
  if (gnss_) add_to_poll_set(gnss_->get());
  poll_set_.push_back({devices_->descriptor(), POLLIN, 0});
}

// In the order of `rebuild_poll_set`; a closed source is never ready.
void LiveReader::read_ready_sources() {
  size_t at = 0;
  const auto ready = [&] { return poll_set_[at++].revents != 0; };
  for (Port& port : ports_) {
    if (ready()) read_port(port);
  }
  for (size_t i = 0; i < cameras_.size(); ++i) {
    if (ready()) read_camera(CameraIndex(i));
  }
  for (size_t i = 0; i < buses_.size(); ++i) {
    if (ready()) read_bus(BusIndex(i));
  }
  if (gnss_ && ready()) read_gnss();
  if (ready() && devices_->consume_changes()) retry_now();
}

// A device may have appeared: retry it before its delay is over.
void LiveReader::retry_now() {
  for (Camera& camera : cameras_) camera.source.retry_now();
  if (gnss_) gnss_->retry_now();
  last_maintenance_ = Stamp::earliest();
}

template <class Source>
void LiveReader::close_source(ReopeningSource<Source>& source, const Error& error) {
  source.close(error, base_.now());
  rebuild_poll_set();  // the descriptor number may be reused
}

void LiveReader::count_dropped(Port& port) {
  const uint64_t dropped = port.source.get()->dropped();
  if (dropped <= port.reported_dropped) return;
  const uint64_t more = dropped - std::exchange(port.reported_dropped, dropped);
  const PortSetup::Sender& sender = port.setup.senders.front();
  if (!port.source.get()->filters_senders()) {
    intake_.add_kernel_dropped(sender.lidar, more, sender.data);
  } else if (sender.data) {
    intake_.add_filtered(sender.lidar, more);
  }
}

void LiveReader::read_port(Port& port) {
  lidar::UdpSource* source = port.source.get();
  for (int batch = 0; batch < kMaxBatchesPerRead; ++batch) {
    const auto count = source->read(datagrams_, [&](const Datagram& datagram) {
      // Count the kernel's drops first: they must not be counted as network losses too.
      count_dropped(port);
      intake_.add_datagram(port.setup.lidar_of(datagram.sender), datagram);
      if (tap_ != nullptr) tap_->add_datagram(datagram);
    });
    if (!count) return close_source(port.source, count.error());
    port.datagrams += *count;
    if (*count < datagrams_.capacity()) return;
  }
}

void LiveReader::read_camera(CameraIndex index) {
  Camera& camera = cameras_[index];
  camera::V4l2Source* source = camera.source.get();
  const auto read = source->read([&](const camera::StreamedImage& image) {
    camera::StreamedImage counted = image;
    counted.sequence += camera.sequence_offset;
    camera.next_sequence = counted.sequence + 1;
    intake_.add_streamed_image(index, counted);
    if (tap_ != nullptr && camera.used) tap_->add_image(index, counted);
  });
  if (read) return;
  camera.damaged_before += source->counters().damaged;
  close_source(camera.source, read.error());
}

void LiveReader::read_bus(BusIndex index) {
  Bus& bus = buses_[index];
  vehicle::SocketCanSource* source = bus.source.get();
  for (int batch = 0; batch < kMaxBatchesPerRead; ++batch) {
    const auto count = source->read(frames_, [&](const vehicle::CanFrame& frame) {
      intake_.add_can_frame(index, frame);
      if (tap_ != nullptr) tap_->add_can_frame(frame);
    });
    if (!count) {
      bus.dropped_before += source->dropped();
      return close_source(bus.source, count.error());
    }
    if (*count < frames_.capacity()) return;
  }
}

void LiveReader::read_gnss() {
  bool any = false;
  const auto read = gnss_->get()->read([&](Stamp stamp, std::string_view line) {
    // Sentences other than RMC and GGA are ignored.
    const auto sentence = gnss::parse_nmea(line);
    if (!sentence) return;
    any = true;
    const GnssFix fix = gnss::stamped_fix(*sentence, stamp);
    intake_.add_gnss(fix, stamp);
    if (tap_ != nullptr) tap_->add_gnss(fix);
  });
  uint64_t& unread = gnss_->state().unread_bytes;
  unread = any || !read ? 0 : unread + *read;
  if (!read) close_source(*gnss_, read.error());
}

void LiveReader::update_source_states() {
  SourceStates& states = intake_.sources();
  update_port_states(states);
  update_camera_states(states);
  update_bus_states(states);
  if (gnss_) states.gnss.state = gnss_->state();
  if (gnss_lidar_) states.gnss.state = states.lidars[*gnss_lidar_];
}

void LiveReader::update_port_states(SourceStates& states) {
  for (Port& port : ports_) {
    SourceState& state = port.source.state();
    if (const lidar::UdpSource* source = port.source.get()) {
      state.buffer_requested = source->buffer_requested();
      state.buffer_granted = source->buffer_granted();
      state.stamp_source = source->stamped_by_hardware() ? "hardware" : "kernel";
    }
    for (const PortSetup::Sender& sender : port.setup.senders) {
      if (sender.data) states.lidars[sender.lidar] = state;
    }
  }
}

void LiveReader::update_camera_states(SourceStates& states) {
  for (size_t i = 0; i < cameras_.size(); ++i) {
    Camera& camera = cameras_[i];
    const camera::V4l2Source* source = camera.source.get();
    states.cameras[i].state = camera.source.state();
    states.cameras[i].state.used = camera.used;
    states.cameras[i].dropped =
        camera.damaged_before + (source != nullptr ? source->counters().damaged : 0);
  }
}

void LiveReader::update_bus_states(SourceStates& states) {
  for (size_t i = 0; i < buses_.size(); ++i) {
    Bus& bus = buses_[i];
    SourceState& state = bus.source.state();
    const vehicle::SocketCanSource* source = bus.source.get();
    if (source != nullptr) {
      const vehicle::BusState controller = source->bus_errors().state();
      state.bus_state =
          controller == vehicle::BusState::kErrorActive ? "" : vehicle::name_of(controller);
      state.bus_off = controller == vehicle::BusState::kBusOff;
      state.open = source->up();
      state.stamp_source = source->stamped_by_hardware() ? "hardware" : "kernel";
      if (!state.open) state.set_problem(source->interface() + ": the interface is down");
    }
    states.buses[i].state = state;
    states.buses[i].state.used = bus.used;
    states.buses[i].dropped = bus.dropped_before + (source != nullptr ? source->dropped() : 0);
  }
}

}  // namespace infuse::daemon
