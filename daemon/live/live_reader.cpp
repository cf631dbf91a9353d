#include "daemon/live/live_reader.hpp"

#include "drivers/velodyne/position_packet.hpp"

namespace infuse::daemon {
namespace {

constexpr int kPatienceMs = 10;  // until ticks, stops and samples that wait are looked after
constexpr Duration kLookPeriod{100'000'000};
constexpr int kBatchesAtOnce = 4;  // of one socket, then the others have their turn

}  // namespace

LiveReader::LiveReader(const LiveSetup& setup, Intake& intake, const receive::TimeBase& base,
                       RecordTap* tap)
    : base_(base),
      intake_(intake),
      tap_(tap),
      lidars_(setup.lidars.size()),
      lidar_of_gps_(setup.lidar_of_gps) {
  for (const PortSetup& port : setup.ports) {
    ports_.push_back({port, {"UDP port " + std::to_string(port.udp.port), [this, udp = port.udp] {
                               return velodyne::UdpSource::open(udp, base_);
                             }}});
  }
  for (size_t i = 0; i < setup.cameras.size(); ++i) {
    const camera::V4l2Options& stream = setup.streams_of_cameras[i];
    cameras_.push_back({{"camera " + stream.device,
                         [this, stream] { return camera::V4l2Source::open(stream, base_); }}});
    wanted_.push_back(i < setup.rig.cameras.size());
  }
  for (size_t i = 0; i < setup.interfaces.size(); ++i) {
    const vehicle::SocketCanOptions& bus = setup.interfaces[i];
    buses_.push_back({{"CAN bus " + bus.interface,
                       [this, bus] { return vehicle::SocketCanSource::open(bus, base_); }}});
    wanted_.push_back(setup.vehicle.buses[i].has_value());
  }
  if (setup.gps) {
    gps_.emplace("receiver " + setup.gps->device, [this, serial = *setup.gps] {
      return vehicle::SerialLineSource::open(serial, base_);
    });
  }
  if (setup.vehicle.has_gps) wanted_.push_back(true);
  std::vector<std::filesystem::path> devices;
  for (const camera::V4l2Options& stream : setup.streams_of_cameras) {
    devices.emplace_back(stream.device);
  }
  if (setup.gps) devices.emplace_back(setup.gps->device);
  devices_.emplace(devices);
  SourceStates& states = intake_.sources();
  states.lidars.resize(lidars_);
  states.streams.resize(setup.streams());
  states.dropped.resize(setup.streams());
}

void LiveReader::run(std::stop_token stop) {
  intake_.start(base_.now());
  while (!stop.stop_requested()) {
    Stamp now = base_.now();
    if (now - looked_ >= kLookPeriod) {
      looked_ = now;
      look_after_sources(now);
      tell_states();
      watch_all();
    }
    const int ready = poll(watched_.data(), watched_.size(), kPatienceMs);
    now = base_.now();
    intake_.advance(now);
    if (ready > 0) read_ready();
    intake_.hand_over_old_samples(now);
    if (tap_ != nullptr) tap_->look_after(now);
  }
  intake_.end(base_.now());
}

void LiveReader::look_after_sources(Stamp now) {
  for (Port& port : ports_) {
    if (port.source.look_after(now)) port.dropped = 0;
    // A group is left by an interface that was made anew.
    if (port.source.get() != nullptr && port.datagrams == port.datagrams_before) {
      port.source.get()->rejoin();
    }
    port.datagrams_before = port.datagrams;
  }
  for (Camera& camera : cameras_) {
    if (camera.source.look_after(now)) camera.sequence_offset = camera.next_sequence;
  }
  for (Bus& bus : buses_) bus.source.look_after(now);
  if (gps_) gps_->look_after(now);
}

/// What is gone has the descriptor −1, which poll passes over.
void LiveReader::watch_all() {
  watched_.clear();
  const auto watch = [&](auto* source) {
    watched_.push_back({source != nullptr ? source->descriptor() : -1, POLLIN, 0});
  };
  for (Port& port : ports_) watch(port.source.get());
  for (Camera& camera : cameras_) watch(camera.source.get());
  for (Bus& bus : buses_) watch(bus.source.get());
  if (gps_) watch(gps_->get());
  watched_.push_back({devices_->descriptor(), POLLIN, 0});
}

// In the order of `watch_all`; what is gone is never ready.
void LiveReader::read_ready() {
  size_t at = 0;
  const auto ready = [&] { return watched_[at++].revents != 0; };
  for (Port& port : ports_) {
    if (ready()) read(port);
  }
  for (size_t i = 0; i < cameras_.size(); ++i) {
    if (ready()) read_camera(i);
  }
  for (size_t i = 0; i < buses_.size(); ++i) {
    if (ready()) read_bus(i);
  }
  if (gps_ && ready()) read_gps();
  if (ready() && devices_->changed()) hurry();
}

// A device may have come: it is tried before its pause is over.
void LiveReader::hurry() {
  for (Camera& camera : cameras_) camera.source.hurry();
  if (gps_) gps_->hurry();
  looked_ = Stamp::earliest();
}

template <class Source>
void LiveReader::lose(Reopening<Source>& source, const Error& error) {
  source.lose(error, base_.now());
  watch_all();  // its descriptor may soon be another's
}

void LiveReader::note_dropped(Port& port) {
  const uint64_t dropped = port.source.get()->dropped();
  if (dropped <= port.dropped) return;
  const PortSetup::Sender& sender = port.setup.senders.front();
  intake_.add_kernel_dropped(sender.lidar, dropped - port.dropped, sender.data);
  port.dropped = dropped;
}

void LiveReader::read(Port& port) {
  velodyne::UdpSource* source = port.source.get();
  for (int batch = 0; batch < kBatchesAtOnce; ++batch) {
    const auto count = source->read(datagrams_, [&](const Datagram& datagram) {
      // The kernel's count first: what it dropped is not missing in the network too.
      note_dropped(port);
      intake_.take(port.setup.lidar_of(datagram.sender), datagram);
      if (lidar_of_gps_ && port.setup.is_of(*lidar_of_gps_, datagram.sender)) {
        take_position(datagram);
      }
      if (tap_ != nullptr) tap_->take(datagram);
    });
    if (!count) return lose(port.source, count.error());
    port.datagrams += *count;
    if (*count < datagrams_.capacity()) return;
  }
}

void LiveReader::read_camera(size_t index) {
  Camera& camera = cameras_[index];
  camera::V4l2Source* source = camera.source.get();
  const auto read = source->read([&](const camera::StreamedPicture& picture) {
    camera::StreamedPicture counted = picture;
    counted.sequence += camera.sequence_offset;
    camera.next_sequence = counted.sequence + 1;
    intake_.take(index, counted);
    if (tap_ != nullptr && wanted_[index]) tap_->take(index, counted);
  });
  if (read) return;
  camera.damaged_before += source->counters().damaged;
  lose(camera.source, read.error());
}

void LiveReader::read_bus(size_t index) {
  Bus& bus = buses_[index];
  vehicle::SocketCanSource* source = bus.source.get();
  for (int batch = 0; batch < kBatchesAtOnce; ++batch) {
    const auto count = source->read(frames_, [&](const vehicle::CanFrame& frame) {
      intake_.take(index, frame);
      if (tap_ != nullptr) tap_->take(frame);
    });
    if (!count) {
      bus.dropped_before += source->dropped();
      return lose(bus.source, count.error());
    }
    if (*count < frames_.capacity()) return;
  }
}

void LiveReader::read_gps() {
  const auto read = gps_->get()->read([&](Stamp stamp, std::string_view line) {
    // Others than these two are passed over.
    if (const auto sentence = velodyne::parse_nmea(line)) take_sentence(stamp, *sentence);
  });
  if (!read) lose(*gps_, read.error());
}

// An RMC has date, speed and course, a GGA has the height; each is a fix of its own.
void LiveReader::take_sentence(Stamp stamp, const velodyne::NmeaFix& sentence) {
  GpsFix fix = sentence.fix;
  fix.stamp = stamp;
  if (!sentence.has_date) fix.utc_ns = 0;
  intake_.take(fix, stamp);
  if (tap_ != nullptr) tap_->take(fix);
}

// The packets repeat a sentence until the receiver says the next.
void LiveReader::take_position(const Datagram& datagram) {
  const auto packet = velodyne::parse_position_packet(datagram.payload);
  if (!packet || !packet->sentence || packet->sentence->fix.utc_ns == last_sentence_ns_) return;
  last_sentence_ns_ = packet->sentence->fix.utc_ns;
  take_sentence(datagram.stamp, *packet->sentence);
}

void LiveReader::tell_states() {
  SourceStates& states = intake_.sources();
  for (Port& port : ports_) {
    SourceState& state = port.source.state();
    if (const velodyne::UdpSource* source = port.source.get()) {
      state.buffer_wanted = source->buffer_wanted();
      state.buffer_granted = source->buffer_granted();
    }
    for (const PortSetup::Sender& sender : port.setup.senders) {
      if (sender.data) states.lidars[sender.lidar] = state;
    }
  }
  size_t stream = 0;
  for (Camera& camera : cameras_) {
    states.streams[stream] = camera.source.state();
    const auto* source = camera.source.get();
    states.dropped[stream++] =
        camera.damaged_before + (source != nullptr ? source->counters().damaged : 0);
  }
  for (Bus& bus : buses_) {
    SourceState& state = bus.source.state();
    const vehicle::SocketCanSource* source = bus.source.get();
    if (source != nullptr) {
      const vehicle::BusState controller = source->bus_errors().state();
      state.bus = controller == vehicle::BusState::kActive ? "" : vehicle::name_of(controller);
      state.bus_off = controller == vehicle::BusState::kBusOff;
      state.open = source->up();
      state.stamps = source->stamped_by_hardware() ? "hardware" : "kernel";
      if (!state.open) state.set_problem(source->interface() + ": the interface is down");
    }
    states.streams[stream] = state;
    states.dropped[stream++] = bus.dropped_before + (source != nullptr ? source->dropped() : 0);
  }
  if (gps_) states.streams[stream] = gps_->state();
  if (lidar_of_gps_) states.streams[stream] = states.lidars[*lidar_of_gps_];
  for (size_t i = 0; i < wanted_.size(); ++i) states.streams[i].wanted = wanted_[i];
}

}  // namespace infuse::daemon
