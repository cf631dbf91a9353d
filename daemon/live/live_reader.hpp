#pragma once

#include <poll.h>

#include <deque>
#include <optional>
#include <stop_token>
#include <vector>

#include "daemon/live/live_setup.hpp"
#include "daemon/live/reopening_source.hpp"
#include "daemon/pipeline/intake.hpp"
#include "daemon/record/record_tap.hpp"
#include "drivers/camera/v4l2_source.hpp"
#include "drivers/gnss/nmea.hpp"
#include "drivers/receive/device_watch.hpp"
#include "drivers/vehicle/serial_line_source.hpp"
#include "drivers/vehicle/socket_can_source.hpp"
#include "drivers/velodyne/udp_source.hpp"

namespace infuse::daemon {

/// The io thread live: waits for the sensors of this host and gives what they say to the intake.
class LiveReader {
 public:
  /// `intake` and `tap` outlive this; `tap` may be null.
  LiveReader(const LiveSetup& setup, Intake& intake, const receive::TimeBase& base, RecordTap* tap);

  /// Until it is asked to stop. The last item is always a kEnd.
  void run(std::stop_token stop);

 private:
  struct Port {
    PortSetup setup;
    ReopeningSource<velodyne::UdpSource> source;
    uint64_t reported_dropped = 0;  // told to the intake
    uint64_t datagrams = 0;
    uint64_t datagrams_before = 0;  // at the last look
  };
  struct Bus {
    ReopeningSource<vehicle::SocketCanSource> source;
    uint64_t dropped_before = 0;  // at sockets that were closed
    uint64_t frames = 0;
  };
  struct Camera {
    ReopeningSource<camera::V4l2Source> source;
    uint64_t sequence_offset = 0;  // so that a camera that is opened again counts on
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
  void add_position_packet(const Datagram& datagram);
  void add_nmea_sentence(Stamp stamp, const gnss::NmeaFix& sentence);
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
  std::optional<size_t> gnss_lidar_;
  int64_t last_sentence_ns_ = 0;  // the time in it
  std::vector<bool> used_;        // by stream
  receive::MessageBatch datagrams_{64, velodyne::UdpSource::kMaxDatagramBytes};
  receive::MessageBatch frames_ = vehicle::make_can_batch();
  std::vector<pollfd> poll_set_;
  Stamp last_maintenance_ = Stamp::earliest();
};

}  // namespace infuse::daemon
