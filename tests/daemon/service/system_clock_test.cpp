#include "daemon/service/system_clock.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <string_view>
#include <vector>

namespace infuse::daemon {
namespace {

/// The answer of chronyd 4.3 with `local stratum 10`, by which its clock is kept, exactly.
std::vector<uint8_t> local_answer() {
  constexpr std::string_view kHex =
      "060200000021000500000000000000001234567800000000000000007f7f01010000000000000000000000000000"
      "00"
      "0000000000000a0000000000006b09e0a9353a2d2800000000000000000000000000000000000000000000000000"
      "0000"
      "000000000000000000";
  std::vector<uint8_t> bytes;
  for (size_t i = 0; i + 1 < kHex.size(); i += 2) {
    bytes.push_back(static_cast<uint8_t>(std::stoi(std::string(kHex.substr(i, 2)), nullptr, 16)));
  }
  return bytes;
}

/// Writes chrony's number: `coefficient` · 2^(`exponent` − 25).
void put(std::vector<uint8_t>& bytes, size_t at, int exponent, int coefficient) {
  const uint32_t bits =
      static_cast<uint32_t>(exponent) << 25 | (static_cast<uint32_t>(coefficient) & 0x1ffffff);
  for (int k = 0; k < 4; ++k)
    bytes[at + static_cast<size_t>(k)] = static_cast<uint8_t>(bits >> (24 - 8 * k));
}

TEST(SystemClock, ReadsChronysAnswer) {
  const auto local = parse_chrony_tracking(local_answer());
  ASSERT_TRUE(local);
  EXPECT_TRUE(local->synchronised);
  EXPECT_EQ(local->max_error_s, 0);
  auto bytes = local_answer();
  put(bytes, 68, -7, -(1 << 23));  // −2^-9 s off
  put(bytes, 92, -3, 1 << 23);     // delay: 2^-5 s
  put(bytes, 96, 2, 1 << 20);      // dispersion: 2^-3 s
  bytes[55] = 3;
  const auto late = parse_chrony_tracking(bytes);
  ASSERT_TRUE(late);
  EXPECT_FALSE(late->synchronised);
  EXPECT_EQ(late->error_s, std::ldexp(1, -9));
  EXPECT_EQ(late->max_error_s, std::ldexp(1, -9) + std::ldexp(1, -3) + std::ldexp(1, -6));
  EXPECT_FALSE(parse_chrony_tracking(std::span(bytes).first(103)));
  bytes[9] = 6;  // a refusal
  EXPECT_FALSE(parse_chrony_tracking(bytes));
}

TEST(SystemClock, AsksWithoutWaiting) {
  const int chrony = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(address);
  ASSERT_EQ(::bind(chrony, reinterpret_cast<sockaddr*>(&address), length), 0);
  ::getsockname(chrony, reinterpret_cast<sockaddr*>(&address), &length);
  SystemClockQuery query(ntohs(address.sin_port));
  static_cast<void>(query.ask());
  std::array<uint8_t, 512> request{};
  sockaddr_in asker{};
  length = sizeof(asker);
  ASSERT_EQ(::recvfrom(chrony, request.data(), request.size(), 0,
                       reinterpret_cast<sockaddr*>(&asker), &length),
            104);
  auto answer = local_answer();
  put(answer, 68, -7, 1 << 23);
  ::sendto(chrony, answer.data(), answer.size(), 0, reinterpret_cast<sockaddr*>(&asker), length);
  const auto clock = query.ask();
  ASSERT_TRUE(clock);
  EXPECT_TRUE(clock->synchronised);
  EXPECT_EQ(clock->error_s, std::ldexp(1, -9));
  ::close(chrony);
}

}  // namespace
}  // namespace infuse::daemon
