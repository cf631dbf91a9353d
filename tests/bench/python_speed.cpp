// What tests/bench/python_speed compares the Python module with: python_speed_reference FOLDER
// reads lines from the standard input, does what they name once, and prints how long it took, s.
// FOLDER: capture.pcap of an HDL-32E; target.f32 and source.f32, coordinates as x…, y…, z….

#include <chrono>
#include <fstream>
#include <iostream>
#include <iterator>

#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/makers/makers.hpp"
#include "drivers/recording/pcap_reader.hpp"
#include "fusion/registration/gicp.hpp"
#ifdef INFUSE_PEER_VELODYNE_DECODER
#include "tests/bench/peer_velodyne_decoder.hpp"
#endif

namespace {

using namespace infuse;

std::vector<uint8_t> read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<float> read_floats(const std::string& path) {
  const std::vector<uint8_t> bytes = read(path);
  std::vector<float> values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
  return values;
}

geometry::PointsView view(const std::vector<float>& xyz) {
  const size_t n = xyz.size() / 3;
  return {std::span(xyz).first(n), std::span(xyz).subspan(n, n), std::span(xyz).last(n)};
}

size_t decode(std::span<const uint8_t> bytes) {
  lidar::DecoderOptions options;
  options.model = *makers::require_model("HDL-32E", "model");
  const auto decoder = *lidar::make_decoder(options);
  auto reader = *recording::PcapReader::from_bytes(bytes, "bytes");
  // The sweep before is kept while the next is decoded, as a loop in Python keeps it.
  static Sweep sweep, before;
  size_t returns = 0;
  const auto pull = [&] {
    while (decoder->pull(sweep)) {
      returns += sweep.size();
      std::swap(sweep, before);
    }
  };
  Datagram datagram;
  while (reader.next(datagram)) {
    decoder->push(datagram);
    pull();
  }
  decoder->finish();
  pull();
  return returns;
}

double align(const std::vector<float>& target, const std::vector<float>& source) {
  const auto to = registration::prepare_cloud(view(target));
  const auto from = registration::prepare_cloud(view(source));
  return registration::gicp(to, from.cloud, Eigen::Isometry3d::Identity()).rms;
}

}  // namespace

int main(int, char** argv) {
  const std::string folder = argv[1];
  const auto capture = read(folder + "/capture.pcap");
  const auto target = read_floats(folder + "/target.f32");
  const auto source = read_floats(folder + "/source.f32");
  std::string what;
  while (std::getline(std::cin, what)) {
    const auto start = std::chrono::steady_clock::now();
    double result = 0;
    if (what == "decode") result = static_cast<double>(decode(capture));
    if (what == "align") result = align(target, source);
#ifdef INFUSE_PEER_VELODYNE_DECODER
    if (what == "peer") result = static_cast<double>(bench::decode_by_peer(capture));
#endif
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    std::cout << took.count() << " " << result << std::endl;
  }
}
