// Replays a ten-minute capture at maximum rate, all threads on one core, and compares with libpcap
// reading the same file.

#include <benchmark/benchmark.h>
#include <sched.h>

#include <cstdio>
#include <fstream>
#include <map>
#include <string>

#include "drivers/recording/pcap_reader.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"

namespace infuse::daemon {
namespace {

constexpr double kCaptureSeconds = 600;

/// Pins this thread and its future children to one core.
void pin_to_one_core() {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(sched_getcpu(), &one);
  sched_setaffinity(0, sizeof(one), &one);
}

/// Current resident memory, MB.
double resident_mb() {
  std::ifstream statm("/proc/self/statm");
  double all = 0, resident = 0;
  statm >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// Written on first use, removed at exit.
const std::filesystem::path& capture_file(double seconds) {
  static const TemporaryFolder folder;
  static std::map<double, std::filesystem::path> made;
  std::filesystem::path& path = made[seconds];
  if (path.empty()) {
    path = folder / (std::to_string(seconds) + ".pcap");
    std::fprintf(stderr, "making a capture of %.0f s\n", seconds);
    fixtures::CaptureOptions options;
    options.duration = from_seconds(seconds);
    if (!fixtures::make_capture(path, options)) std::abort();
  }
  return path;
}

void replay_hdl32e(benchmark::State& state) {
  const std::filesystem::path path = capture_file(kCaptureSeconds);
  const std::filesystem::path brief = capture_file(kCaptureSeconds / 20);
  pin_to_one_core();
  (void)run_replay(brief);
  const double after_brief_mb = resident_mb();
  for (auto _ : state) {
    const auto result = run_replay(path);
    if (!result) state.SkipWithError(result.error().message().c_str());
  }
  state.SetItemsProcessed(static_cast<int64_t>(kCaptureSeconds) *
                          static_cast<int64_t>(state.iterations()));
  state.SetLabel("x real time");
  state.counters["memory_growth_mb"] = resident_mb() - after_brief_mb;
}

void read_by_libpcap(benchmark::State& state) {
  const std::filesystem::path path = capture_file(kCaptureSeconds);
  pin_to_one_core();
  for (auto _ : state) {
    auto reader = recording::PcapReader::open(path);
    Datagram datagram;
    uint64_t bytes = 0;
    while (reader->next(datagram)) bytes += datagram.payload.size();
    benchmark::DoNotOptimize(bytes);
  }
  state.SetItemsProcessed(static_cast<int64_t>(kCaptureSeconds) *
                          static_cast<int64_t>(state.iterations()));
  state.SetLabel("x real time");
}

BENCHMARK(replay_hdl32e)
    ->Name("replay/hdl32e")
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(read_by_libpcap)
    ->Name("replay/hdl32e/baseline:libpcap_reading_only")
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace infuse::daemon
