// Misbehaving clients of the daemon, and a simulated GNSS receiver.
//
//   vm-clients never-read SOCKET SECONDS   watches everything and never reads
//   vm-clients connect-many SOCKET COUNT   opens COUNT connections at once, then closes them
//   vm-clients refused SOCKET              sends requests that this user must not send; 0: all were
//                                          refused
//   vm-clients kill PID SOCKET FILE        kills the daemon and queries the next one; prints both
//                                          times (ms, monotonic clock) and how long the virtual
//                                          machine was stalled between them, by its host's FILE
//   vm-clients gnss-receiver LINK          simulates a GNSS receiver on a serial line at LINK

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <deque>
#include <string>

#include "tests/daemon/socket_client.hpp"

namespace {

using infuse::daemon::SocketClient;

int watch_without_reading(const char* socket, unsigned seconds) {
  SocketClient client(socket);
  if (!client.send("{\"op\":\"watch\"}\n")) return 1;
  sleep(seconds);
  return 0;
}

int open_connections(const char* socket, int count) {
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = files.rlim_max;
  setrlimit(RLIMIT_NOFILE, &files);
  std::deque<SocketClient> clients;
  int connected = 0;
  for (int i = 0; i < count; ++i) connected += clients.emplace_back(socket).connected() ? 1 : 0;
  std::printf("%d of %d connected\n", connected, count);
  return connected == count ? 0 : 1;
}

long now_ms() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return time.tv_sec * 1000 + time.tv_nsec / 1'000'000;
}

/// True if the daemon answers. systemd holds the socket: a client that connects while there is no
/// daemon waits for the next one.
bool is_answering(const char* socket) {
  SocketClient client(socket);
  if (!client.read_line(20'000) || !client.send("{\"op\":\"devices\"}\n")) return false;
  const auto answer = client.read_line(20'000);
  return answer && answer->find("\"class\":\"DEVICES\"") != std::string::npos;
}

/// Time that each of the two virtual processors has waited for a host processor, ns, as written by
/// the host.
std::array<long, 2> read_cpu_waits(const char* file) {
  std::array<long, 2> waits{};
  for (int tries = 0; tries < 1000; ++tries) {  // the file may be in the middle of an update
    std::FILE* const stream = std::fopen(file, "r");
    if (stream == nullptr) break;
    const int numbers = std::fscanf(stream, "%ld %ld", &waits[0], &waits[1]);
    std::fclose(stream);
    if (numbers == 2) return waits;
  }
  return {};
}

int kill_daemon(pid_t daemon, const char* socket, const char* file) {
  const auto before = read_cpu_waits(file);
  const long killed = now_ms();
  if (kill(daemon, SIGKILL) != 0) return 1;
  while (!is_answering(socket)) {
    if (now_ms() - killed > 20'000) return 1;
  }
  const long answered = now_ms();
  const auto after = read_cpu_waits(file);
  // Of the processor that waited less.
  const long stalled_ms = std::min(after[0] - before[0], after[1] - before[1]) / 1'000'000;
  std::printf("%ld %ld %ld\n", killed, answered, stalled_ms);
  return 0;
}

/// Simulates a receiver on a pseudo-terminal, which behaves like a serial device.
int simulate_gnss_receiver(const char* link) {
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
  if (terminal < 0 || grantpt(terminal) != 0 || unlockpt(terminal) != 0) return 1;
  unlink(link);
  if (symlink(ptsname(terminal), link) != 0) return 1;
  for (int fifths = 0;; ++fifths) {
    char body[96];
    const int seconds = fifths / 5 % 60, minutes = fifths / 300 % 60;
    std::snprintf(body, sizeof(body),
                  "GPRMC,12%02d%02d.%d0,A,4807.0380,N,01131.0000,E,10.0,84.4,211126,,", minutes,
                  seconds, fifths % 5 * 2);
    unsigned sum = 0;
    for (const char* c = body; *c != 0; ++c) sum ^= static_cast<unsigned char>(*c);
    dprintf(terminal, "$%s*%02X\r\n", body, sum);  // lost if nobody reads
    char echo[256];
    while (read(terminal, echo, sizeof(echo)) > 0) {
    }
    usleep(200'000);
  }
}

/// Requests that only the daemon's owner may send, and invalid requests.
const struct {
  const char* what;
  std::string line;
} kForbiddenRequests[] = {
    {"recalibrate", R"({"op":"recalibrate"})"},
    {"apply", R"({"op":"apply"})"},
    {"rollback", R"({"op":"rollback"})"},
    {"freeze", R"({"op":"freeze"})"},
    {"freeze off", R"({"op":"freeze","on":false})"},
    {"record", R"({"op":"record"})"},
    {"record elsewhere", R"({"op":"record","name":"../../../etc/x"})"},
    {"record to an absolute name", R"({"op":"record","name":"/etc/x"})"},
    {"end a recording", R"({"op":"record","on":false})"},
    {"an unknown op", R"({"op":"shutdown"})"},
    {"no op", "{}"},
    {"an op that is not a string", R"({"op":["poll"]})"},
    {"not an object", "[1,2,3]"},
    {"not JSON", "GET / HTTP/1.1"},
    {"zeros", std::string(100, '\0')},
    {"not UTF-8", "{\"op\":\"\xff\xfe\"}"},
    {"a key twice", R"({"op":"devices","op":"freeze"})"},
    {"deep nesting", R"({"op":"poll","x":)" + std::string(1500, '[')},
    {"an overlong line", std::string(5000, 'x')},
    {"an unknown class", R"({"op":"watch","classes":["SECRETS"]})"},
    {"a class that is not a string", R"({"op":"watch","classes":[{}]})"},
};

/// True if the answer is an error, or the connection is closed or impossible.
bool is_refused(const char* socket, const std::string& line) {
  SocketClient client(socket);
  if (!client.connected()) return true;
  if (!client.read_line()) return false;  // the greeting
  client.send(line + "\n");
  const auto answer = client.read_line();
  return !answer || answer->find("\"class\":\"ERROR\"") != std::string::npos;
}

/// True if some of many requests at once are refused.
bool flood_is_limited(const char* socket) {
  SocketClient client(socket);
  if (!client.connected()) return true;
  client.read_line();
  std::string lines;
  for (int i = 0; i < 300; ++i) lines += "{\"op\":\"devices\"}\n";
  client.send(lines);
  for (int i = 0; i < 300; ++i) {
    const auto answer = client.read_line(3000);
    if (!answer || answer->find("\"class\":\"ERROR\"") != std::string::npos) return true;
  }
  return false;
}

int try_forbidden_requests(const char* socket) {
  int attempts = 0, allowed = 0;
  const auto report = [&](const char* what, bool was_refused) {
    std::printf("        %-7s %s\n", was_refused ? "refused" : "ALLOWED", what);
    ++attempts;
    allowed += was_refused ? 0 : 1;
  };
  for (const auto& attempt : kForbiddenRequests)
    report(attempt.what, is_refused(socket, attempt.line));
  report("300 requests at once", flood_is_limited(socket));
  std::printf("        %d attempts, %d allowed\n", attempts, allowed);
  return allowed == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 2 ? argv[1] : "";
  if (what == "never-read" && argc == 4)
    return watch_without_reading(argv[2], static_cast<unsigned>(std::atoi(argv[3])));
  if (what == "connect-many" && argc == 4) return open_connections(argv[2], std::atoi(argv[3]));
  if (what == "kill" && argc == 5) return kill_daemon(std::atoi(argv[2]), argv[3], argv[4]);
  if (what == "gnss-receiver" && argc == 3) return simulate_gnss_receiver(argv[2]);
  if (what == "refused" && argc == 3) return try_forbidden_requests(argv[2]);
  return 2;
}
