// Writes seeds of the fuzzers, one folder for each: packets of every Velodyne model, sound and
// after every family of mutations; captures of every link type; a small sound file of every kind.
// Usage: fuzz_seeds FOLDER, in the folder of the sources.

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <osmium/io/pbf_output.hpp>
#include <osmium/io/reader.hpp>
#include <osmium/io/writer.hpp>
#include <osmium/io/xml_input.hpp>

#include "daemon/calibration/saved_calibrations.hpp"
#include "daemon/mapping/cloud_file.hpp"
#include "daemon/mapping/map_tables.hpp"
#include "daemon/mapping/place_map.hpp"
#include "drivers/camera/png_encoder.hpp"
#include "drivers/mcap/mcap_writer.hpp"
#include "drivers/ros/serialisation.hpp"
#include "drivers/ros/sweep_cloud.hpp"
#include "drivers/text/text_file.hpp"
#include "fixtures/lidar/nmea_sentence.hpp"
#include "fixtures/velodyne/db_xml.hpp"
#include "fixtures/velodyne/position_encoder.hpp"
#include "fusion/streetmap/map_from_image.hpp"
#include "tests/drivers/hesai/made_turns.hpp"
#include "tests/drivers/import/mat_bytes.hpp"
#include "tests/drivers/lcm/lcm_bytes.hpp"
#include "tests/drivers/ouster/made_metadata.hpp"
#include "tests/drivers/ouster/made_packet.hpp"
#include "tests/drivers/recording/compress.hpp"
#include "tests/drivers/robosense/made_packet.hpp"
#include "tests/drivers/rosbag/bag_bytes.hpp"
#include "tests/drivers/velodyne/mutation_families.hpp"
#include "tests/fuzz/text_seeds.hpp"

namespace {

using namespace infuse;
using namespace infuse::velodyne;

constexpr size_t kPacketsEach = 4;

template <class Bytes>
void write_seed(const std::filesystem::path& path, const Bytes& bytes) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

/// As hesai_packet_fuzz reads it: the model, the bytes beyond its shortest packet, then packets.
void write_hesai_packets(const std::filesystem::path& folder) {
  for (const hesai::ModelInfo& info : hesai::models()) {
    for (const hesai::ReturnMode mode :
         {hesai::ReturnMode::kStrongest, hesai::ReturnMode::kLastStrongest}) {
      const auto packets = hesai::make_turns(info.model, mode, 0.05);
      const size_t beyond = packets[0].payload.size() - info.body_end() - info.tail.size;
      std::vector<uint8_t> bytes = {static_cast<uint8_t>(info.model), static_cast<uint8_t>(beyond)};
      for (size_t i = 0; i < std::min(packets.size(), kPacketsEach); ++i) {
        bytes.insert(bytes.end(), packets[i].payload.begin(), packets[i].payload.end());
      }
      write_seed(folder / (std::string(info.name) + "_" + std::to_string(static_cast<int>(mode))),
                 bytes);
    }
  }
}

/// As robosense_packet_fuzz reads it: the model, then data packets around an information packet.
void write_robosense_packets(const std::filesystem::path& folder) {
  const std::array<robosense::PlainModel, 4> models{{32, 16, {32, 3}, {32, 4}}};
  for (size_t model = 0; model < models.size(); ++model) {
    for (const bool dual : {false, true}) {
      const auto packets = robosense::make_turns(models[model], dual, 0.05);
      const std::vector<int> elevations{1494, 1303, 1092}, azimuths{-405, 361, -400};
      const auto info = robosense::make_info_packet(elevations, azimuths, dual ? 0 : 4);
      std::vector<uint8_t> bytes = {static_cast<uint8_t>(model)};
      for (size_t i = 0; i < std::min(packets.size(), kPacketsEach); ++i) {
        bytes.insert(bytes.end(), packets[i].payload.begin(), packets[i].payload.end());
        if (i == 1) bytes.insert(bytes.end(), info.begin(), info.end());
      }
      write_seed(folder / (std::to_string(model) + (dual ? "_dual" : "_single")), bytes);
    }
  }
}

/// As velodyne_packet_fuzz reads it: the model, then packets.
void write_packets(const std::filesystem::path& path, size_t model,
                   const std::vector<SentPacket>& packets) {
  std::vector<uint8_t> bytes = {static_cast<uint8_t>(model)};
  for (size_t i = 0; i < std::min(packets.size(), kPacketsEach); ++i) {
    bytes.insert(bytes.end(), packets[i].payload.begin(), packets[i].payload.end());
  }
  write_seed(path, bytes);
}

void write_data_packets(const std::filesystem::path& folder) {
  std::mt19937 random(1);
  for (size_t i = 0; i < models().size(); ++i) {
    const ModelInfo& info = models()[i];
    for (const ReturnMode mode : {ReturnMode::kStrongest, ReturnMode::kDual}) {
      if (mode == ReturnMode::kDual && !info.has_dual_return) continue;
      const std::string name =
          std::to_string(i) + (mode == ReturnMode::kDual ? "_dual_" : "_single_");
      auto packets = make_scene({.model = info.model,
                                 .mode = mode,
                                 .turns = 0.05,
                                 .calibration = built_in_calibration(info.model)})
                         .packets;
      packets.resize(std::min(packets.size(), kPacketsEach));
      write_packets(folder / (name + "sound"), i, packets);
      for (const MutationFamily& family : mutation_families()) {
        auto mutated = packets;
        family.apply(mutated, random);
        write_packets(folder / (name + family.name), i, mutated);
      }
    }
  }
}

/// As pcap_fuzz reads them: the number of the link type, then frames after their lengths.
void write_captures(const std::filesystem::path& folder) {
  using namespace recording::testing;
  const Bytes payload = make_payload(64);
  const Bytes packet = ipv4(udp(payload));
  Bytes longer = packet;  // as VeloView saves position packets
  longer[2] = 4;
  Bytes null = {2, 0, 0, 0};  // AF_INET before the packet
  Bytes loop = {0, 0, 0, 2};
  add(null, packet);
  add(loop, packet);
  const std::vector<std::vector<Bytes>> captures = {
      {null},
      {ethernet(packet), ethernet(packet, {{0x8100, 5}}),
       ethernet(packet, {{0x88A8, 1}, {0x8100, 2}}), ethernet(longer),
       ethernet(ipv4(payload, {.protocol = 6})), ethernet(packet, {}, 0x86DD)},
      {packet, ipv4(udp(payload), {.option_words = 3})},
      {loop},
      {linux_cooked_v1(packet)},
      {packet},
      {linux_cooked_v2(packet)},
      {ethernet(ipv4({payload.begin(), payload.begin() + 32}, {.identification = 7, .more = true})),
       ethernet(ipv4({payload.begin() + 32, payload.end()}, {.identification = 7, .offset = 32}))},
  };
  for (size_t link = 0; link < captures.size(); ++link) {
    Bytes bytes = {static_cast<uint8_t>(link)};
    for (const Bytes& frame : captures[link]) {
      bytes.push_back(static_cast<uint8_t>(frame.size()));
      add(bytes, frame);
    }
    write_seed(folder / std::to_string(link), bytes);
  }
  const Bytes file = pcap(kEthernet, {{1, 0, ethernet(packet)}});
  write_seed(folder / "pcap", file);
  write_seed(folder / "pcapng", pcapng(kEthernet, {{1, 0, ethernet(packet)}}));
  write_seed(folder / ".." / "compressed_capture_fuzz" / "gzip", gzip(file));
  write_seed(folder / ".." / "compressed_capture_fuzz" / "zstd", zstd(file));
  write_seed(folder / ".." / "udp_tap_fuzz" / "packet", packet);
}

/// Two images, and a map of regions.
void write_images(const std::filesystem::path& folder) {
  CameraFrame image;
  image.width = image.height = 24;
  image.pixels.assign(24 * 24, 240);
  std::fill(image.pixels.begin(), image.pixels.begin() + 200, uint8_t{100});
  if (const auto map = streetmap::make_map_from_image(image, {}, "drawn")) {
    write_seed(folder / "street_map_fuzz" / "drawn", *map);
  }
  if (const auto png = camera::encode_png(image)) {
    write_seed(folder / "image_fuzz" / "png", *png);
  }
}

/// Points ring by ring, as KITTI's .bin files have them.
void write_sweep(const std::filesystem::path& folder) {
  std::vector<float> values;
  for (int ring = 0; ring < 4; ++ring) {
    for (int column = 0; column < 40; ++column) {
      const double azimuth = 0.157 * column;
      const auto add = [&](double value) { values.push_back(static_cast<float>(value)); };
      add(10 * std::cos(azimuth));
      add(10 * std::sin(azimuth));
      add(-0.5 * ring);
      add(0.3);
    }
  }
  write_seed(folder / "sweep_bin_fuzz" / "rings",
             std::string_view(reinterpret_cast<const char*>(values.data()), 4 * values.size()));
}

/// A file that the repository has.
void write_copy(const std::filesystem::path& to, const char* from) {
  if (const auto text = text::read_text(from, size_t{1} << 20)) write_seed(to, *text);
}

/// The seed in XML as the binary form, uncompressed; osm_fuzz reads it after an odd byte.
void write_binary_map(const std::filesystem::path& folder) {
  const auto xml = text::read_text(folder / "xml", size_t{1} << 20);
  if (!xml) return;
  osmium::io::Reader reader(osmium::io::File(xml->data() + 1, xml->size() - 1, "osm"));
  const std::filesystem::path binary = folder / "binary.osm.pbf";
  osmium::io::Writer writer(osmium::io::File(binary.string(), "pbf,pbf_compression=none"),
                            osmium::io::overwrite::allow);
  while (osmium::memory::Buffer buffer = reader.read()) writer(std::move(buffer));
  writer.close();
  reader.close();
  if (const auto bytes = text::read_text(binary, size_t{1} << 20)) {
    write_seed(folder / "binary", "1" + *bytes);
  }
  std::filesystem::remove(binary);
}

/// As ros_message_fuzz reads it: the type, then the message.
template <class T>
void write_message(const std::filesystem::path& folder, uint8_t type, const T& message) {
  for (const auto encoding : {ros::Encoding::kCdr, ros::Encoding::kRos1}) {
    const bool ros1 = encoding == ros::Encoding::kRos1;
    std::vector<uint8_t> bytes;
    ros::encode(message, encoding, bytes);
    bytes.insert(bytes.begin(), static_cast<uint8_t>(type + (ros1 ? 128 : 0)));
    write_seed(folder / (std::to_string(type) + (ros1 ? "_ros1" : "_cdr")), bytes);
  }
}

void write_messages(const std::filesystem::path& folder) {
  Sweep sweep;
  sweep.resize(16);
  for (size_t i = 0; i < sweep.size(); ++i) {
    sweep.x[i] = static_cast<float>(i) - 8;
    sweep.y[i] = 5;
    sweep.z[i] = static_cast<float>(i % 2);
    sweep.reflectivity[i] = 0.5f;
    sweep.ring[i] = static_cast<uint16_t>(i % 2);
    sweep.column[i] = static_cast<uint16_t>(i / 2);
    sweep.time_offset_ns[i] = static_cast<int32_t>(i * 1000);
    sweep.return_kind[i] = ReturnKind::kLast;
  }
  std::vector<uint8_t> data;
  write_message(folder, 0, ros::to_cloud(sweep, "lidar", data));
  write_message(folder, 1, ros::Image{{}, 2, 3, "bgr8", 0, 9, std::span(data).first(18)});
  write_message(folder, 2, ros::CompressedImage{{}, "png", std::span(data).first(18)});
  write_message(folder, 3, ros::CameraInfo{.distortion_model = "plumb_bob", .d = {1, 2, 3, 4, 5}});
  write_message(folder, 4, ros::TfMessage{{{{}, "lidar", {}}, {{}, "camera", {}}}});
  write_message(folder, 5, ros::VelodyneScan{{}, {{}}});
  write_message(folder, 13, ros::PandarScan{{}, {{}}});
  write_message(folder, 14, ros::NebulaPackets{{}, {{{}, std::span(data).first(18)}}});
  write_message(folder, 15, ros::RslidarPacket{{}, 1, 0, std::span(data).first(18)});
  write_message(folder, 17, ros::OusterPacket{std::span(data).first(18)});
  write_message(folder, 11, ros::DiagnosticArray{{}, {{1, "a", "b", "c", {{"k", "v"}}}}});
}

void write_mcap(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  for (const auto compression :
       {mcap::Compression::kNone, mcap::Compression::kLz4, mcap::Compression::kZstd}) {
    auto writer = mcap::McapWriter::create(
        folder / ("file_" + std::string(mcap::name_of(compression))), {.compression = compression});
    if (!writer) continue;
    const auto channel =
        writer->add_channel({"/a", "cdr", {"b", "ros2msg", "int8 c"}, {{"k", "v"}}});
    for (int k = 0; channel && k < 3; ++k)
      static_cast<void>(writer->write(*channel, Stamp(), Stamp(), std::vector<uint8_t>(20, 7)));
    static_cast<void>(writer->write_metadata("m", {{"k", "v"}}));
    static_cast<void>(writer->close());
  }
}

void write_bags(const std::filesystem::path& folder) {
  for (const char* compression : {"none", "bz2", "lz4"}) {
    rosbag::BagBytes bag;
    bag.add_chunk(compression, bag.connection(0, "/a", "b/C") + bag.message(0, 1, 2, "content"));
    write_seed(folder / compression, bag.bytes());
  }
}

void write_ford(const std::filesystem::path& folder) {
  using namespace infuse::importers;
  const std::string cameras = mat_structure(1, {"K", "R", "t"},
                                            mat_doubles(3, 3, {400, 0, 0, 0, 410, 0, 300, 200, 1}) +
                                                mat_doubles(3, 3, {1, 0, 0, 0, 0, 1, 0, -1, 0}) +
                                                mat_doubles(3, 1, {0.1, 0.2, 0.3}),
                                            "PARAM");
  write_seed(folder / "cameras", mat_file(cameras));
  write_seed(folder / "compressed", mat_file(mat_compressed(cameras)));
  write_seed(folder / "scan",
             mat_file(mat_structure(
                 1, {"timestamp_laser", "X_wv"},
                 mat_doubles(1, 1, {1.26e15}) + mat_doubles(6, 1, {1, 2, 3, 0, 0, 0.5}), "SCAN")));
  write_seed(folder / "poses",
             mat_file(mat_structure(1, {"utime", "pos", "rph", "vel"},
                                    mat_doubles(1, 1, {1.26e15}) + mat_doubles(3, 1, {1, 2, 3}) +
                                        mat_doubles(3, 1, {0, 0, 1}) + mat_doubles(3, 1, {1, 0, 0}),
                                    "Pose")));
  write_seed(folder / "stamps", std::string("1 1260800000000000\n2,1260800000125000\n"));
  write_seed(folder / "image", std::string("P6\n2 1\n255\nabcdef"));
}

void write_logs(const std::filesystem::path& folder) {
  const auto packets = make_scene({.turns = 0.01}).packets;
  if (packets.empty()) return;
  const std::string packet(packets[0].payload.begin(), packets[0].payload.end());
  constexpr uint64_t kUs = 1'700'000'000'000'000;
  write_seed(folder / "poses", lcm::make_event(0, kUs, "POSE", "content") +
                                   lcm::make_event(1, kUs + 9, "POSE", "contents"));
  write_seed(folder / "packets",
             lcm::make_event(0, kUs, "VELODYNE", lcm::make_raw_message(kUs, packet)) +
                 lcm::make_event(1, kUs + 9, "RAW", packet));
}

/// As map_files_fuzz reads them: which file of a map folder, then its content.
void write_map_files(const std::filesystem::path& folder) {
  std::vector<daemon::MapKeyframe> keyframes(2);
  keyframes[1].keyframe.stamp = Stamp::from_ns(5);
  keyframes[1].keyframe.distance_driven = 2;
  for (auto& keyframe : keyframes) keyframe.cloud_checksum = "0123456789abcdef";
  mapping::Submap cloud;
  cloud.resize(3);
  std::vector<mapping::Closure> closures(1);
  closures[0].to = 1;
  const std::pair<const char*, std::string> files[] = {
      {"keyframes", daemon::format_keyframes(keyframes)},
      {"fixes", daemon::format_fixes({{}})},
      {"closures", daemon::format_closures(closures)},
      {"places", daemon::format_places(std::vector<places::PlaceDescriptor>(1))},
      {"cloud", daemon::format_cloud_pcd(cloud)}};
  char number = 0;
  for (const auto& [name, bytes] : files) write_seed(folder / name, number++ + bytes);
  const char of_points = static_cast<char>(5 + 6 * cloud.size());
  write_seed(folder / "compressed_cloud", of_points + daemon::compress_cloud(cloud).value());
}

/// As ouster_packet_fuzz reads it: profile and shape, then packets of 16 beams.
void write_ouster(const std::filesystem::path& folder) {
  for (size_t profile = 0; profile < ouster::kProfiles.size(); ++profile) {
    for (const bool nested : {false, true}) {
      ouster::MadeMetadata values;
      values.nested = nested;
      values.beams = 16;
      values.profile = ouster::kProfiles[profile].name;
      values.columns = "512";
      values.window = "[0, 511]";
      const std::string text = ouster::made_metadata(values);
      const std::string name = values.profile + (nested ? "_nested" : "_flat");
      write_seed(folder / "ouster_metadata_fuzz" / name, text);
      std::vector<uint8_t> bytes = {static_cast<uint8_t>(profile),
                                    static_cast<uint8_t>(nested ? 0b1001 : 0b0101)};
      const auto metadata = ouster::parse_metadata(text, name).value();
      for (const uint16_t first : std::array<uint16_t, 4>{480, 496, 0, 16}) {
        const auto packet = ouster::made_packet(
            metadata, {.frame_id = first > 100 ? 7u : 8u,
                       .first_measurement_id = first,
                       .device_ns = 1'000'000'000 + (first > 100 ? first : first + 512) * 195'312});
        bytes.insert(bytes.end(), packet.begin(), packet.end());
      }
      write_seed(folder / "ouster_packet_fuzz" / name, bytes);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: fuzz_seeds FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  write_data_packets(folder / "velodyne_packet_fuzz");
  write_hesai_packets(folder / "hesai_packet_fuzz");
  write_robosense_packets(folder / "robosense_packet_fuzz");
  write_ouster(folder);
  write_captures(folder / "pcap_fuzz");
  const std::string sentence = fixtures::rmc_sentence(
      {.utc_ns = 1'700'000'000'000'000'000, .latitude = 0.8, .longitude = -2.1});
  write_seed(folder / "velodyne_position_fuzz" / "rmc",
             velodyne::encode_position_packet({.counter_us = 5, .sentence = sentence}));
  for (const Model model : {Model::kHdl64eS2, Model::kHdl64eS3}) {
    write_seed(folder / "velodyne_db_xml_fuzz" / std::to_string(static_cast<int>(model)),
               velodyne::write_db_xml(built_in_calibration(model)));
  }
  for (const fuzz::TextSeed& seed : fuzz::kTextSeeds) {
    write_seed(folder / seed.fuzzer / seed.name, std::string_view(seed.text));
  }
  write_binary_map(folder / "osm_fuzz");
  write_mcap(folder / "mcap_fuzz");
  write_bags(folder / "rosbag_fuzz");
  write_logs(folder / "lcm_fuzz");
  write_ford(folder / "ford_fuzz");
  write_seed(folder / "viewer_request_fuzz" / "subscribe",
             std::string(R"({"op":"subscribe","subscriptions":[{"id":7,"channelId":2}]})"));
  write_seed(folder / "viewer_request_fuzz" / "unsubscribe",
             std::string(R"({"op":"unsubscribe","subscriptionIds":[7]})"));
  write_seed(folder / "viewer_request_fuzz" / "protocols",
             std::string("foxglove.websocket.v1, foxglove.sdk.v1"));
  write_map_files(folder / "map_files_fuzz");
  write_messages(folder / "ros_message_fuzz");
  write_images(folder);
  write_sweep(folder);
  write_seed(folder / "saved_calibrations_fuzz" / "frozen",
             daemon::format_calibrations({.cameras = {{.camera = "front", .frozen = true}}}));
  write_copy(folder / "config_fuzz" / "demo", "fixtures/demo/infused.toml");
  write_copy(folder / "config_fuzz" / "example", "packaging/examples/infused.toml");
  write_copy(folder / "rig_toml_fuzz" / "tutorial", "docs/tutorials/rig.toml");
  write_copy(folder / "drive_toml_fuzz" / "tutorial", "docs/tutorials/rig.toml");
  return 0;
}
