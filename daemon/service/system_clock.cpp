#include "daemon/service/system_clock.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/timex.h>

#include <array>
#include <cmath>

#include "drivers/measurement/big_endian.hpp"

namespace infuse::daemon {
namespace {

// candm.h of chrony 4: a request and its answer have the same length.
constexpr uint8_t kProtocol = 6, kRequest = 1, kAnswer = 2;
constexpr uint16_t kAskTracking = 33, kTracking = 5, kNotSynchronised = 3;
constexpr size_t kBytes = 104;
constexpr int kMaxUnanswered = 5;

/// chrony's number: 7 bits of exponent, 25 of coefficient, both in two's complement.
double read_number(std::span<const uint8_t> bytes) {
  const uint32_t bits = big_endian::read_u32(bytes, 0);
  const auto exponent = static_cast<int>(static_cast<int32_t>(bits) >> 25);
  const int coefficient = static_cast<int32_t>(bits << 7) >> 7;
  return std::ldexp(coefficient, exponent - 25);
}

std::optional<SystemClock> ask_kernel() {
  timex state{};  // modes 0: nothing is changed
  const int status = ::adjtimex(&state);
  if (status < 0) return std::nullopt;
  constexpr double kMicrosecond = 1e-6;
  return SystemClock{.synchronised = status != TIME_ERROR && (state.status & STA_UNSYNC) == 0,
                     .max_error_s = static_cast<double>(state.maxerror) * kMicrosecond,
                     .error_s = static_cast<double>(state.esterror) * kMicrosecond};
}

}  // namespace

std::optional<SystemClock> parse_chrony_tracking(std::span<const uint8_t> answer) {
  const auto u16 = [&](size_t at) { return big_endian::read_u16(answer, at); };
  if (answer.size() < kBytes || answer[0] != kProtocol || answer[1] != kAnswer ||
      u16(6) != kTracking || u16(8) != 0) {
    return std::nullopt;
  }
  const double correction = std::abs(read_number(answer.subspan(68)));
  const double delay = read_number(answer.subspan(92)),
               dispersion = read_number(answer.subspan(96));
  return SystemClock{.synchronised = u16(54) != kNotSynchronised,
                     .max_error_s = correction + dispersion + delay / 2,  // as its manual has it
                     .error_s = correction};
}

SystemClockQuery::SystemClockQuery(uint16_t port)
    : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  sockaddr_in chrony{};
  chrony.sin_family = AF_INET;
  chrony.sin_port = htons(port);
  chrony.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&chrony), sizeof(chrony)) != 0) {
    socket_ = host::FileDescriptor();
  }
}

std::optional<SystemClock> SystemClockQuery::ask() {
  std::array<uint8_t, 512> bytes{};
  ++unanswered_;
  for (ssize_t size; (size = ::recv(socket_.get(), bytes.data(), bytes.size(), 0)) > 0;) {
    const auto clock = parse_chrony_tracking({bytes.data(), static_cast<size_t>(size)});
    if (!clock) continue;
    last_ = clock;
    unanswered_ = 0;
  }
  if (unanswered_ > kMaxUnanswered) last_.reset();
  const std::array<uint8_t, kBytes> request = {kProtocol, kRequest, 0, 0, 0, kAskTracking};
  static_cast<void>(::send(socket_.get(), request.data(), request.size(), MSG_NOSIGNAL));
  return last_ ? last_ : ask_kernel();
}

}  // namespace infuse::daemon
