// Clients of the daemon that do what they should not, and a receiver for it.
//
//   vm-clients hold SOCKET SECONDS     watches everything and never reads
//   vm-clients crowd SOCKET COUNT      connects so often at once, then lets go
//   vm-clients refused SOCKET          asks for what is not for this user; 0: all of it was refused
//   vm-clients kill PID SOCKET FILE    kills the daemon and asks the next; tells both moments, ms
//                                      of the monotonic clock, and how long the machine stood
//                                      still between them, by FILE of its host
//   vm-clients receiver LINK           a GPS receiver on a serial line, where LINK leads to

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

/// The daemon's socket is systemd's: who connects while there is no daemon waits for the next.
bool is_answering(const char* socket) {
  SocketClient client(socket);
  if (!client.read_line(20'000) || !client.send("{\"op\":\"devices\"}\n")) return false;
  const auto answer = client.read_line(20'000);
  return answer && answer->find("\"class\":\"DEVICES\"") != std::string::npos;
}

/// For how long each of two processors has waited for one of the host's, ns, as the host writes it.
std::array<long, 2> read_cpu_waits(const char* file) {
  std::array<long, 2> waits{};
  for (int tries = 0; tries < 1000; ++tries) {  // it may be about to be written
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
  // By the processor that waited less.
  const long stalled_ms = std::min(after[0] - before[0], after[1] - before[1]) / 1'000'000;
  std::printf("%ld %ld %ld\n", killed, answered, stalled_ms);
  return 0;
}

/// A pseudo-terminal: who opens LINK cannot tell it from a serial device.
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
    dprintf(terminal, "$%s*%02X\r\n", body, sum);  // lost where nobody reads
    char echo[256];
    while (read(terminal, echo, sizeof(echo)) > 0) {
    }
    usleep(200'000);
  }
}

/// What nobody but its owner may ask of the daemon, and what nobody may.
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
    {"an op that is none", R"({"op":"shutdown"})"},
    {"no op", "{}"},
    {"an op that is no string", R"({"op":["poll"]})"},
    {"no object", "[1,2,3]"},
    {"no JSON", "GET / HTTP/1.1"},
    {"zeros", std::string(100, '\0')},
    {"no UTF-8", "{\"op\":\"\xff\xfe\"}"},
    {"a key twice", R"({"op":"devices","op":"freeze"})"},
    {"deep nesting", R"({"op":"poll","x":)" + std::string(1500, '[')},
    {"a line too long", std::string(5000, 'x')},
    {"a class that is none", R"({"op":"watch","classes":["SECRETS"]})"},
    {"a class that is no string", R"({"op":"watch","classes":[{}]})"},
};

/// The answer is an error, or the connection is closed, or there is none.
bool is_refused(const char* socket, const std::string& line) {
  SocketClient client(socket);
  if (!client.connected()) return true;
  if (!client.read_line()) return false;  // the greeting
  client.send(line + "\n");
  const auto answer = client.read_line();
  return !answer || answer->find("\"class\":\"ERROR\"") != std::string::npos;
}

/// Of many requests at once some are refused.
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
