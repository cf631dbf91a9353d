#include "daemon/mapping/cloud_file.hpp"

#include <bit>
#include <cmath>
#include <cstring>

#include "drivers/mcap/compression.hpp"
#include "drivers/recording/pcd_header.hpp"

namespace infuse::daemon {
namespace {

static_assert(std::endian::native == std::endian::little, "clouds are written in memory order");

constexpr size_t kCloudPointBytes = 4 * sizeof(float);

void append_points(const mapping::Submap& cloud, std::string& bytes) {
  const size_t begin = bytes.size();
  bytes.resize(begin + cloud.size() * kCloudPointBytes);
  char* out = bytes.data() + begin;
  for (size_t i = 0; i < cloud.size(); ++i) {
    for (const float value : {cloud.x[i], cloud.y[i], cloud.z[i], cloud.reflectivity[i]}) {
      std::memcpy(out, &value, sizeof(value));
      out += sizeof(value);
    }
  }
}

std::string cloud_header(size_t points) {
  const std::string count = std::to_string(points);
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\n"
         "COUNT 1 1 1 1\nWIDTH " +
         count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
}

bool is_cloud_header(const recording::PcdHeader& header) {
  constexpr std::array<const char*, 4> kNames{"x", "y", "z", "intensity"};
  if (header.data != recording::PcdData::kBinary || header.fields.size() != kNames.size()) {
    return false;
  }
  for (size_t f = 0; f < kNames.size(); ++f) {
    const recording::PcdField& field = header.fields[f];
    if (field.name != kNames[f] || field.type != 'F' || field.bytes() != sizeof(float)) {
      return false;
    }
  }
  return true;
}

}  // namespace

std::string format_cloud_pcd(const mapping::Submap& cloud) {
  std::string bytes = cloud_header(cloud.size());
  append_points(cloud, bytes);
  return bytes;
}

std::string format_cloud_ply(const mapping::Submap& cloud) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(cloud.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty float intensity\n"
      "end_header\n";
  append_points(cloud, bytes);
  return bytes;
}

Result<mapping::Submap> parse_cloud_pcd(std::string_view bytes, const std::string& name) {
  const auto header = recording::parse_pcd_header(bytes);
  if (!header) return fail(header.error().what, name, header.error().hint);
  if (!is_cloud_header(*header)) {
    return fail("not a cloud of a map", name, "expected binary float32 x y z intensity");
  }
  if (bytes.size() - header->data_offset != header->points * kCloudPointBytes) {
    return fail("the cloud is truncated", name);
  }
  mapping::Submap cloud;
  cloud.resize(header->points);
  const char* in = bytes.data() + header->data_offset;
  for (size_t i = 0; i < cloud.size(); ++i) {
    for (float* value : {&cloud.x[i], &cloud.y[i], &cloud.z[i], &cloud.reflectivity[i]}) {
      std::memcpy(value, in, sizeof(float));
      in += sizeof(float);
      if (!std::isfinite(*value)) return fail("a point is not finite", name);
    }
  }
  return cloud;
}

Result<std::string> compress_cloud(const mapping::Submap& cloud) {
  const std::string plain = format_cloud_pcd(cloud);
  std::vector<uint8_t> out;
  return mcap::compress_chunk(mcap::Compression::kZstd,
                              {reinterpret_cast<const uint8_t*>(plain.data()), plain.size()}, out)
      .map([&] { return std::string(out.begin(), out.end()); });
}

Result<mapping::Submap> parse_compressed_cloud(std::string_view bytes, size_t points,
                                               const std::string& name) {
  std::vector<uint8_t> plain;
  const auto done = mcap::decompress_chunk(
      mcap::Compression::kZstd, {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()},
      cloud_header(points).size() + points * kCloudPointBytes, plain);
  if (!done) return fail(done.error().what, name);
  auto cloud = parse_cloud_pcd({reinterpret_cast<const char*>(plain.data()), plain.size()}, name);
  if (cloud && cloud->size() != points) return fail("not as many points as stated", name);
  return cloud;
}

}  // namespace infuse::daemon
