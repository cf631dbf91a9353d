// A map of a large extract: copies of a small one to 20 MB of XML over 1000 km², with a wood of
// 370 km². The small one is a real extract, if INFUSE_REAL_DATA names a folder with them.

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "daemon/streetmap/street_map_file.hpp"
#include "drivers/text/text_file.hpp"
#include "tests/folders.hpp"
#include "tests/large_extract.hpp"

namespace infuse::daemon {
namespace {

/// Writes the extract; returns its size, bytes.
size_t write_extract(const std::filesystem::path& path) {
  constexpr size_t kMaxBytes = 1 << 26;
  const char* const real = std::getenv("INFUSE_REAL_DATA");
  if (real == nullptr) {
    const auto town = text::read_text(source_folder() + "/fixtures/maps/altfeld.osm", kMaxBytes);
    const std::string xml = large_extract(*town, 17, 0.36, 49.99, 8.49, true);
    return text::write_text(path, xml) ? xml.size() : 0;
  }
  const std::string unpack = "bzcat " + std::string(real) + "/street/07.osm.bz2 > " + path.string();
  if (std::system(unpack.c_str()) != 0) return 0;
  const auto extract = text::read_text(path, kMaxBytes);
  const std::string xml = large_extract(*extract, 2, 0.36, 48.9792593, 8.388319, true);
  return text::write_text(path, xml) ? xml.size() : 0;
}

void large_map(benchmark::State& state) {
  const auto path = std::filesystem::temp_directory_path() / "infuse_large_map.osm";
  const size_t xml_bytes = write_extract(path);
  size_t map_bytes = 0;
  for (auto _ : state) {
    const auto made = make_street_map(path, {});
    if (!made) return state.SkipWithError(made.error().message().c_str());
    map_bytes = made->bytes.size();
  }
  std::filesystem::remove(path);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.counters["xml_MB"] = static_cast<double>(xml_bytes) / 1e6;
  state.counters["map_MB"] = static_cast<double>(map_bytes) / 1e6;
  state.counters["peak_memory_MB"] = static_cast<double>(usage.ru_maxrss) / 1e3;
}

BENCHMARK(large_map)->Name("streetmap/large_map")->Unit(benchmark::kSecond)->Iterations(1);

}  // namespace
}  // namespace infuse::daemon
