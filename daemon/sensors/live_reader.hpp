#pragma once

#include <poll.h>

#include <deque>
#include <optional>
#include <stop_token>
#include <vector>

#include "daemon/pipeline/intake.hpp"
#include "daemon/record/record_tap.hpp"
#include "daemon/sensors/reopening_source.hpp"
#include "daemon/setup/sensor_setup.hpp"
#include "drivers/camera/v4l2_source.hpp"
#include "drivers/gnss/nmea.hpp"
#include "drivers/host/device_watch.hpp"
#include "drivers/lidar/udp_source.hpp"
#include "drivers/makers/makers.hpp"
#include "drivers/vehicle/serial_line_source.hpp"
#include "drivers/vehicle/socket_can_source.hpp"

namespace infuse::daemon {

/// The io thread of a live run: waits for the sensors of this host and passes their data to the
/// intake.
class LiveReader {
 public:
  /// `intake` and `tap` must outlive this object; `tap` may be null.
  LiveReader(const SensorSetup& setup, Intake& intake, const host::TimeBase& base, RecordTap* tap);

  /// Runs until a stop is requested. The last item passed on is always a kEnd.
  void run(std::stop_token stop);

 private:
  struct Port {
    PortSetup setup;
    ReopeningSource<lidar::UdpSource> source;
    uint64_t reported_dropped = 0;  // already counted by the intake
    uint64_t datagrams = 0;
    uint64_t datagrams_before = 0;  // at the last maintenance
  };
  struct Bus {
    ReopeningSource<vehicle::SocketCanSource> source;
    bool used = true;             // false: frames are only counted
    uint64_t dropped_before = 0;  // by sockets that have been closed
    uint64_t frames = 0;
  };
  struct Camera {
    ReopeningSource<camera::V4l2Source> source;
    uint64_t sequence_offset = 0;  // keeps sequence numbers increasing when a camera is reopened
    uint64_t next_sequence = 0;
    uint64_t damaged_before = 0;
    bool used = true;  // false: images are only counted
  };

  void reopen_sources(Stamp now);
  void rebuild_poll_set();
  void read_ready_sources();
  void retry_now();
  void read_port(Port& port);
  void count_dropped(Port& port);
  void read_camera(CameraIndex camera);
  void read_bus(BusIndex bus);
  void read_gnss();
  template <class Source>
  void close_source(ReopeningSource<Source>& source, const Error& error);
  void update_source_states();
  void update_port_states(SourceStates& states);
  void update_camera_states(SourceStates& states);
  void update_bus_states(SourceStates& states);

  const host::TimeBase base_;
  Intake& intake_;
  RecordTap* tap_;
  std::deque<Port> ports_;
  std::deque<Camera> cameras_;  // by CameraIndex
  std::deque<Bus> buses_;       // by BusIndex
  std::optional<ReopeningSource<vehicle::SerialLineSource>> gnss_;
  std::optional<host::DeviceWatch> devices_;
  std::optional<LidarIndex> gnss_lidar_;
  host::MessageBatch datagrams_{64, makers::max_datagram()};
  host::MessageBatch frames_ = vehicle::make_can_batch();
  std::vector<pollfd> poll_set_;
  Stamp last_maintenance_ = Stamp::earliest();
};

}  // namespace infuse::daemon
