#include "drivers/recording/sweep_export.hpp"

#include <array>
#include <bit>
#include <cstring>
#include <string>

#include "drivers/recording/sweep_files.hpp"
#include "drivers/text/numbers.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::recording {
namespace {

static_assert(std::endian::native == std::endian::little, "records are written in memory order");

template <class Value>
void add_binary(std::string& bytes, Value value) {
  std::array<char, sizeof(Value)> raw{};
  std::memcpy(raw.data(), &value, sizeof(Value));
  bytes.append(raw.data(), raw.size());
}

// One packed record per return, identical in PCD and PLY; times only where they are known.
void add_records(std::string& bytes, const Sweep& sweep) {
  constexpr size_t kRecordBytes = 5 * 4 + 2 * 2 + 4 + 1;
  bytes.reserve(bytes.size() + kRecordBytes * sweep.size());
  for (size_t i = 0; i < sweep.size(); ++i) {
    add_binary(bytes, sweep.x[i]);
    add_binary(bytes, sweep.y[i]);
    add_binary(bytes, sweep.z[i]);
    add_binary(bytes, sweep.range[i]);
    add_binary(bytes, sweep.reflectivity[i]);
    add_binary(bytes, sweep.ring[i]);
    add_binary(bytes, sweep.column[i]);
    if (sweep.has_times) add_binary(bytes, sweep.time_offset_ns[i]);
    add_binary(bytes, static_cast<uint8_t>(sweep.return_kind[i]));
  }
}

std::string to_pcd(const Sweep& sweep) {
  const std::string count = std::to_string(sweep.size());
  const auto timed = [&](const char* text) { return sweep.has_times ? text : ""; };
  std::string bytes = "# .PCD v0.7\n# stamp_ns " + std::to_string(sweep.stamp.ns()) +
                      "\nVERSION 0.7\nFIELDS x y z range intensity ring column" +
                      timed(" time_offset_ns") + " return_kind\nSIZE 4 4 4 4 4 2 2" + timed(" 4") +
                      " 1\nTYPE F F F F F U U" + timed(" I") + " U\nCOUNT 1 1 1 1 1 1 1" +
                      timed(" 1") + " 1\nWIDTH " + count +
                      "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
  add_records(bytes, sweep);
  return bytes;
}

std::string to_ply(const Sweep& sweep) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\ncomment stamp_ns " +
                      std::to_string(sweep.stamp.ns()) + "\nelement vertex " +
                      std::to_string(sweep.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\n"
                      "property float range\nproperty float intensity\n"
                      "property ushort ring\nproperty ushort column\n";
  if (sweep.has_times) bytes += "property int time_offset_ns\n";
  bytes += "property uchar return_kind\nend_header\n";
  add_records(bytes, sweep);
  return bytes;
}

template <class Value>
void add_field(std::string& text, Value value, char end) {
  text::append_number(text, value);
  text += end;
}

std::string to_csv(const Sweep& sweep) {
  std::string text = "x,y,z,range,reflectivity,ring,column,";
  text += sweep.has_times ? "time_offset_ns,return_kind\n" : "return_kind\n";
  for (size_t i = 0; i < sweep.size(); ++i) {
    add_field(text, sweep.x[i], ',');
    add_field(text, sweep.y[i], ',');
    add_field(text, sweep.z[i], ',');
    add_field(text, sweep.range[i], ',');
    add_field(text, sweep.reflectivity[i], ',');
    add_field(text, sweep.ring[i], ',');
    add_field(text, sweep.column[i], ',');
    if (sweep.has_times) add_field(text, sweep.time_offset_ns[i], ',');
    add_field(text, static_cast<int>(sweep.return_kind[i]), '\n');
  }
  return text;
}

}  // namespace

std::optional<SweepFormat> detect_sweep_format(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".pcd") return SweepFormat::kPcd;
  if (extension == ".ply") return SweepFormat::kPly;
  if (extension == ".csv") return SweepFormat::kCsv;
  if (extension == ".bin") return SweepFormat::kBin;
  return std::nullopt;
}

Result<void> export_sweep(const Sweep& sweep, const std::filesystem::path& path,
                          SweepFormat format) {
  switch (format) {
    case SweepFormat::kPcd:
      return text::write_text(path, to_pcd(sweep));
    case SweepFormat::kPly:
      return text::write_text(path, to_ply(sweep));
    case SweepFormat::kCsv:
      return text::write_text(path, to_csv(sweep));
    case SweepFormat::kBin:
      return write_sweep_bin(path, sweep);
  }
  return fail("unknown format", path.string());
}

}  // namespace infuse::recording
