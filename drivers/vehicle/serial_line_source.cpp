#include "drivers/vehicle/serial_line_source.hpp"

#include <fcntl.h>
#include <termios.h>

#include "drivers/host/system_error.hpp"

namespace infuse::vehicle {
namespace {

std::optional<speed_t> termios_speed(uint32_t baud) {
  switch (baud) {
    case 4800:
      return B4800;
    case 9600:
      return B9600;
    case 19200:
      return B19200;
    case 38400:
      return B38400;
    case 57600:
      return B57600;
    case 115200:
      return B115200;
    case 230400:
      return B230400;
    case 460800:
      return B460800;
    default:
      return std::nullopt;
  }
}

}  // namespace

std::optional<std::string> SerialOptions::invalid() const {
  if (device.empty() || device.front() != '/') return "'" + device + "' is not a device path";
  if (!termios_speed(baud)) return std::to_string(baud) + " baud is not a supported speed";
  return std::nullopt;
}

Result<SerialLineSource> SerialLineSource::open(const SerialOptions& options,
                                                const host::TimeBase& base) {
  if (auto wrong = options.invalid()) return fail(*wrong, options.device);
  SerialLineSource source(options, base);
  source.device_ = host::FileDescriptor(
      ::open(options.device.c_str(), O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!source.device_) {
    return host::fail_errno("cannot be opened", options.device,
                            errno == EACCES ? "add the user to the group dialout" : "");
  }
  termios settings{};
  if (tcgetattr(source.device_.get(), &settings) != 0) {
    return host::fail_errno("not a serial device", options.device);
  }
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cc[VMIN] = 1;  // so that 0 bytes mean a device that hung up
  settings.c_cc[VTIME] = 0;
  cfsetspeed(&settings, *termios_speed(options.baud));
  if (tcsetattr(source.device_.get(), TCSANOW, &settings) != 0) {
    return host::fail_errno("cannot be set up", options.device);
  }
  return source;
}

Result<size_t> SerialLineSource::handle_read_error(ssize_t count) const {
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
  if (count == 0) return fail("the device hung up", options_.device);
  return host::fail_errno("cannot be read", options_.device);
}

}  // namespace infuse::vehicle
