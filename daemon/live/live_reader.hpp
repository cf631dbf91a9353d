#pragma once

#include <poll.h>

#include <deque>
#include <optional>
#include <stop_token>
#include <vector>

#include "daemon/live/live_setup.hpp"
#include "daemon/live/reopening.hpp"
#include "daemon/pipeline/intake.hpp"
#include "daemon/record/record_tap.hpp"
#include "drivers/camera/v4l2_source.hpp"
#include "drivers/receive/device_watch.hpp"
#include "drivers/vehicle/serial_line_source.hpp"
#include "drivers/vehicle/socket_can_source.hpp"
#include "drivers/velodyne/nmea.hpp"
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
    Reopening<velodyne::UdpSource> source;
    uint64_t dropped = 0;  // told to the intake
    uint64_t datagrams = 0;
    uint64_t datagrams_before = 0;  // at the last look
  };
  struct Bus {
    Reopening<vehicle::SocketCanSource> source;
    uint64_t dropped_before = 0;  // at sockets that were closed
    uint64_t frames = 0;
  };
  struct Camera {
    Reopening<camera::V4l2Source> source;
    uint64_t sequence_offset = 0;  // so that a camera that is opened again counts on
    uint64_t next_sequence = 0;
    uint64_t damaged_before = 0;
  };

  void look_after_sources(Stamp now);
  void watch_all();
  void read_ready();
  void hurry();
  void read(Port& port);
  void note_dropped(Port& port);
  void read_camera(size_t camera);
  void read_bus(size_t bus);
  void read_gps();
  template <class Source>
  void lose(Reopening<Source>& source, const Error& error);
  void take_position(const Datagram& datagram);
  void take_sentence(Stamp stamp, const velodyne::NmeaFix& sentence);
  void tell_states();

  const receive::TimeBase base_;
  Intake& intake_;
  RecordTap* tap_;
  std::deque<Port> ports_;
  std::deque<Camera> cameras_;
  std::deque<Bus> buses_;
  std::optional<Reopening<vehicle::SerialLineSource>> gps_;
  std::optional<receive::DeviceWatch> devices_;
  size_t lidars_;
  std::optional<size_t> lidar_of_gps_;
  int64_t last_sentence_ns_ = 0;  // the time in it
  std::vector<bool> wanted_;      // by stream
  receive::MessageBatch datagrams_{64, velodyne::UdpSource::kMaxBytes};
  receive::MessageBatch frames_ = vehicle::can_batch();
  std::vector<pollfd> watched_;
  Stamp looked_ = Stamp::earliest();
};

}  // namespace infuse::daemon
