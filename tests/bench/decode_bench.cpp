// Decodes packets in memory to complete sweeps, on one core, and compares with PCL's grabbers on
// the same packets.
//
// PCL's decoder is private, behind a queue and a thread. The baseline calls the decoder itself
// (`toPointClouds`, once per packet, with one subscriber for the sweeps), so that neither the queue
// nor the thread counts. A return is an entry with a distance; both sides decode the same packets
// repeatedly.

#include <benchmark/benchmark.h>
#include <pcl/io/vlp_grabber.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/simulator/drive_writer.hpp"
#include "fixtures/velodyne/packet_encoder.hpp"
#include "tests/folders.hpp"
#include "tests/pcap_packets.hpp"
#include "tests/real_data.hpp"

namespace infuse {
namespace {

using velodyne::Model;

/// Names PCL's types and its decoder; never instantiated.
struct PclTypes : pcl::HDLGrabber {
  using Packet = pcl::HDLGrabber::HDLDataPacket;
};
using PclDecode = void (pcl::HDLGrabber::*)(PclTypes::Packet*);

PclDecode pcl_decode();

/// Access checks do not apply to the arguments of an explicit instantiation.
template <PclDecode kMember>
struct PrivateAccess {
  friend PclDecode pcl_decode() { return kMember; }
};
template struct PrivateAccess<&pcl::HDLGrabber::toPointClouds>;

struct Input {
  std::vector<std::vector<uint8_t>> packets;
  std::vector<Stamp> stamps;
  int64_t returns = 0;
};

int64_t count_returns(const std::vector<uint8_t>& packet) {
  int64_t returns = 0;
  for (size_t block = 0; block < velodyne::kBlocks; ++block) {
    for (size_t slot = 0; slot < velodyne::kSlotsPerBlock; ++slot) {
      const size_t at = block * velodyne::kBlockSize + 4 + 3 * slot;
      if (velodyne::read_u16(packet.data() + at) != 0) ++returns;
    }
  }
  return returns;
}

void add(Input& input, Stamp stamp, std::vector<uint8_t> packet) {
  input.returns += count_returns(packet);
  input.stamps.push_back(stamp);
  input.packets.push_back(std::move(packet));
}

/// 1.5 s at ten turns per second; 84 % of the directions have a return, as in hdl32e-monterey.
Input generate_packets(Model model, velodyne::ReturnMode mode) {
  const velodyne::ModelInfo& info = velodyne::model_info(model);
  const double period_s = to_seconds(velodyne::sequence_period(info, info.cycle));
  velodyne::PacketEncoder encoder({.model = model, .mode = mode});
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto echo = [&] {
    const double range = uniform(random) < 0.84 ? 1 + 60 * uniform(random) : 0;
    return fixtures::Echo{range, static_cast<uint8_t>(255 * uniform(random))};
  };
  std::vector<fixtures::Echo> first(info.slots());
  std::vector<fixtures::Echo> last(info.slots());
  Input input;
  for (double t = 0; t < 1.5; t += period_s) {
    for (size_t slot = 0; slot < info.slots(); ++slot) {
      first[slot] = echo();
      last[slot] = uniform(random) < 0.9 ? first[slot] : echo();
    }
    const auto azimuth = static_cast<uint16_t>(static_cast<int64_t>(t * 360'000) % 36'000);
    if (encoder.add_sequence(azimuth, static_cast<uint32_t>(t * 1e6), first, last)) {
      add(input, Stamp() + from_seconds(t), {encoder.packet().begin(), encoder.packet().end()});
    }
  }
  return input;
}

/// Loads a real capture if it is available.
Input load_capture(const char* name, Model model) {
  const std::filesystem::path path = real_data(std::string("velodyne/") + name + ".pcap");
  if (path.empty() || !std::filesystem::exists(path)) {
    return generate_packets(model, velodyne::ReturnMode::kStrongest);
  }
  Input input;
  for (CapturedDatagram& datagram : read_capture(path)) {
    if (datagram.payload.size() != velodyne::kPacketSize) continue;
    add(input, datagram.stamp, std::move(datagram.payload));
  }
  return input;
}

void run_ours(benchmark::State& state, Model model, const Input& input) {
  velodyne::Decoder assembler({.model = &velodyne::lidar_model(model)});
  Sweep sweep;
  for ([[maybe_unused]] auto _ : state) {
    for (size_t i = 0; i < input.packets.size(); ++i) {
      assembler.push({input.stamps[i], 1, 2368, 2368, input.packets[i]});
      while (assembler.pull(sweep)) benchmark::DoNotOptimize(sweep.x.data());
    }
  }
  state.SetItemsProcessed(state.iterations() * input.returns);
}

template <class Grabber>
void run_pcl(benchmark::State& state, Grabber& grabber, Input& input) {
  size_t points = 0;
  std::function<void(const pcl::PointCloud<pcl::PointXYZI>::ConstPtr&)> count =
      [&](const pcl::PointCloud<pcl::PointXYZI>::ConstPtr& cloud) { points += cloud->size(); };
  grabber.registerCallback(count);
  const PclDecode decode = pcl_decode();
  for ([[maybe_unused]] auto _ : state) {
    for (std::vector<uint8_t>& packet : input.packets) {
      (grabber.*decode)(reinterpret_cast<PclTypes::Packet*>(packet.data()));
    }
  }
  if (points == 0) state.SkipWithError("PCL returned no points");
  state.SetItemsProcessed(state.iterations() * input.returns);
}

/// 0.3 s of the simulated street as packets of the given sensor.
Input simulate_packets(const std::string& model) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("infuse-bench-" + std::to_string(::getpid()));
  const std::string text =
      "duration_s = 0.35\n[world]\nmap = \"altfeld.osm\"\nroute = [100, 104]\n"
      "[vehicle]\nspeed = 8\nstart_speed = 8\n[[lidar]]\nmodel = \"" +
      model + "\"\nposition = [1.0, 0.0, 1.9]\n";
  Input input;
  const auto scenario =
      simulator::parse_scenario(text, "bench.toml", source_folder() + "/fixtures/maps");
  if (!scenario) return input;
  auto simulation = simulator::Simulation::create(*scenario, 2);
  if (!simulation || !simulator::write_drive(*simulation, folder, [](double) {})) return input;
  for (CapturedDatagram& datagram : read_capture(folder / "lidar.pcap")) {
    if (datagram.payload.size() != velodyne::kPacketSize) continue;
    add(input, datagram.stamp, std::move(datagram.payload));
  }
  std::filesystem::remove_all(folder);
  return input;
}

/// Ranges in steps of 2 mm, sorted.
std::vector<int> our_ranges(Model model, const Input& input) {
  // PCL applies no corrections without a calibration file of the unit.
  velodyne::Calibration uncorrected;
  for (size_t i = 0; i < uncorrected.beams.size(); ++i) {
    uncorrected.beams[i].elevation = velodyne::built_in_calibration(model).beams[i].elevation;
  }
  velodyne::Decoder assembler(
      {.model = &velodyne::lidar_model(model),
       .calibration = std::make_shared<velodyne::UnitCalibration>(model, uncorrected)});
  Sweep sweep;
  std::vector<int> ranges;
  const auto collect = [&] {
    while (assembler.pull(sweep)) {
      for (const float range : sweep.range)
        ranges.push_back(static_cast<int>(std::lround(range * 500)));
    }
  };
  for (size_t i = 0; i < input.packets.size(); ++i) {
    assembler.push({input.stamps[i], 1, 2368, 2368, input.packets[i]});
    collect();
  }
  assembler.finish();
  collect();
  std::sort(ranges.begin(), ranges.end());
  return ranges;
}

template <class Grabber>
std::vector<int> pcl_ranges(Grabber& grabber, Input& input) {
  std::vector<int> ranges;
  std::function<void(const pcl::PointCloud<pcl::PointXYZI>::ConstPtr&)> collect =
      [&](const pcl::PointCloud<pcl::PointXYZI>::ConstPtr& cloud) {
        for (const pcl::PointXYZI& p : *cloud) {
          if (!std::isfinite(p.x)) continue;
          ranges.push_back(static_cast<int>(std::lround(std::hypot(p.x, p.y, p.z) * 500)));
        }
      };
  grabber.registerCallback(collect);
  const PclDecode decode = pcl_decode();
  for (std::vector<uint8_t>& packet : input.packets) {
    (grabber.*decode)(reinterpret_cast<PclTypes::Packet*>(packet.data()));
  }
  std::sort(ranges.begin(), ranges.end());
  return ranges;
}

/// Checks that PCL decodes the simulated packets to the same ranges: every range from PCL (complete
/// turns only, from azimuth 0 to 0) must be one of ours.
template <class Grabber>
void compare(benchmark::State& state, Grabber& grabber, Model model, const char* name) {
  Input input = simulate_packets(name);
  const std::vector<int> ours = our_ranges(model, input);
  const std::vector<int> theirs = pcl_ranges(grabber, input);
  if (theirs.size() < ours.size() / 2) return state.SkipWithError("PCL returned too few ranges");
  if (!std::includes(ours.begin(), ours.end(), theirs.begin(), theirs.end())) {
    return state.SkipWithError("PCL returned other ranges for these packets");
  }
  state.counters["ranges_equal"] = static_cast<double>(theirs.size());
  run_pcl(state, grabber, input);
}

void register_all() {
  static Input hdl32e = load_capture("hdl32e-monterey", Model::kHdl32e);
  static Input vlp16 = load_capture("vlp16-gps", Model::kVlp16);
  static Input vlp16_dual = load_capture("vlp16-dual-return", Model::kVlp16);
  static Input vlp32c = load_capture("vlp32c-half-turn", Model::kVlp32c);
  static const Input vls128 = generate_packets(Model::kVls128, velodyne::ReturnMode::kDual);
  static const Input hdl64e = generate_packets(Model::kHdl64eS3, velodyne::ReturnMode::kStrongest);
  const auto ours = [](const char* name, Model model, const Input& input) {
    benchmark::RegisterBenchmark(
        name, [model, &input](benchmark::State& state) { run_ours(state, model, input); });
  };
  ours("decode/hdl32e", Model::kHdl32e, hdl32e);
  benchmark::RegisterBenchmark("decode/hdl32e/baseline:pcl", [](benchmark::State& state) {
    pcl::HDLGrabber grabber("", "");
    run_pcl(state, grabber, hdl32e);
  });
  ours("decode/vlp16", Model::kVlp16, vlp16);
  benchmark::RegisterBenchmark("decode/vlp16/baseline:pcl", [](benchmark::State& state) {
    pcl::VLPGrabber grabber("");
    run_pcl(state, grabber, vlp16);
  });
  ours("decode/vlp16-dual", Model::kVlp16, vlp16_dual);
  benchmark::RegisterBenchmark("decode/vlp16-dual/baseline:pcl", [](benchmark::State& state) {
    pcl::VLPGrabber grabber("");
    run_pcl(state, grabber, vlp16_dual);
  });
  benchmark::RegisterBenchmark("decode/simulated-by-pcl/hdl32e", [](benchmark::State& state) {
    pcl::HDLGrabber grabber("", "");
    compare(state, grabber, Model::kHdl32e, "HDL-32E");
  });
  benchmark::RegisterBenchmark("decode/simulated-by-pcl/hdl64e", [](benchmark::State& state) {
    pcl::HDLGrabber grabber("", "");
    compare(state, grabber, Model::kHdl64eS2, "HDL-64E S2");
  });
  benchmark::RegisterBenchmark("decode/simulated-by-pcl/vlp16", [](benchmark::State& state) {
    pcl::VLPGrabber grabber("");
    compare(state, grabber, Model::kVlp16, "VLP-16");
  });
  ours("decode/vlp32c", Model::kVlp32c, vlp32c);
  ours("decode/hdl64e-s3", Model::kHdl64eS3, hdl64e);
  ours("decode/vls128-dual", Model::kVls128, vls128);
}

[[maybe_unused]] const bool registered = (register_all(), true);

}  // namespace
}  // namespace infuse
