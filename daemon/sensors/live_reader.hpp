#pragma once

#include <poll.h>

#include <deque>
#include <optional>
#include <stop_token>
#include <vector>

#include "daemon/pipeline/intake.hpp"
#include "daemon/record/record_tap.hpp"
#include "daemon/sensors/live_setup.hpp"
#include "daemon/sensors/reopening_source.hpp"
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
  LiveReader(const LiveSetup& setup, Intake& intake, const receive::TimeBase& base, RecordTap* tap);

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
    uint64_t dropped_before = 0;  // by sockets that have been closed
    uint64_t frames = 0;
  };
  struct Camera {
    ReopeningSource<camera::V4l2Source> source;
    uint64_t sequence_offset = 0;  // keeps sequence numbers increasing when a camera is reopened
    uint64_t next_sequence = 0;
    uint64_t damaged_before = 0;
  };

  void reopen_sources(Stamp now);
  void rebuild_poll_set();
  void read_ready_sources();
  void retry_now();
  void read_port(Port& port);
  void count_dropped(Port& port);
  void read_camera(size_t camera);
  void read_bus(size_t bus);
  void read_gnss();
  template <class Source>
  void close_source(ReopeningSource<Source>& source, const Error& error);
  void update_source_states();

  const receive::TimeBase base_;
  Intake& intake_;
  RecordTap* tap_;
  std::deque<Port> ports_;
  std::deque<Camera> cameras_;
  std::deque<Bus> buses_;
  std::optional<ReopeningSource<vehicle::SerialLineSource>> gnss_;
  std::optional<receive::DeviceWatch> devices_;
  size_t lidars_;
  std::optional<LidarIndex> gnss_lidar_;
  std::vector<bool> used_;  // by stream index
  receive::MessageBatch datagrams_{64, makers::max_datagram()};
  receive::MessageBatch frames_ = vehicle::make_can_batch();
  std::vector<pollfd> poll_set_;
  Stamp last_maintenance_ = Stamp::earliest();
};

}  // namespace infuse::daemon
