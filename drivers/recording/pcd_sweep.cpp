#include "drivers/recording/pcd_sweep.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "drivers/recording/lzf.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "drivers/recording/times_csv.hpp"
#include "drivers/text/numbers.hpp"

namespace infuse::recording {
namespace {

static_assert(std::endian::native == std::endian::little, "point files are little-endian");

constexpr size_t kMaxPointBytes = 256 << 20;  // decompressed
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Values of x, y, z, intensity, ring, time, column and kind of all points; empty if the file has
/// no such field.
using Columns = std::array<std::vector<double>, 8>;
constexpr size_t kRing = 4, kTime = 5, kColumn = 6, kKind = 7;

template <class Value>
double read(const char* at) {
  Value value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

double read_value(const char* at, const PcdField& field) {
  if (field.type == 'F') return field.size == 4 ? read<float>(at) : read<double>(at);
  const bool is_signed = field.type == 'I';
  switch (field.size) {
    case 1:
      return is_signed ? read<int8_t>(at) : read<uint8_t>(at);
    case 2:
      return is_signed ? read<int16_t>(at) : read<uint16_t>(at);
    case 4:
      return is_signed ? read<int32_t>(at) : read<uint32_t>(at);
    default:
      return is_signed ? read<int64_t>(at) : read<uint64_t>(at);
  }
}

/// Field of the file for each column; −1: none.
using FieldIndices = std::array<int, 8>;

/// Reads a block of binary points. `field_after_field`: all values of a field are contiguous.
void read_columns(const char* bytes, const PcdHeader& header, const FieldIndices& field_indices,
                  bool field_after_field, Columns& columns) {
  size_t begin = 0;
  for (size_t f = 0; f < header.fields.size(); ++f) {
    const PcdField& field = header.fields[f];
    const size_t step = field_after_field ? field.bytes() : header.point_bytes();
    for (size_t c = 0; c < field_indices.size(); ++c) {
      if (field_indices[c] != static_cast<int>(f)) continue;
      columns[c].resize(header.points);
      for (size_t i = 0; i < header.points; ++i) {
        columns[c][i] = read_value(bytes + begin + i * step, field);
      }
    }
    begin += field_after_field ? field.bytes() * header.points : field.bytes();
  }
}

Result<void> read_binary(std::string_view points, const PcdHeader& header,
                         const FieldIndices& field_indices, Columns& columns) {
  const size_t length = header.points * header.point_bytes();
  if (points.size() < length) {
    return fail("ends after " + std::to_string(points.size()) + " of " + std::to_string(length) +
                " bytes of points");
  }
  read_columns(points.data(), header, field_indices, false, columns);
  return {};
}

Result<void> read_compressed(std::string_view points, const PcdHeader& header,
                             const FieldIndices& field_indices, Columns& columns) {
  if (points.size() < 8) return fail("ends before its compressed points");
  std::array<uint32_t, 2> sizes{};
  std::memcpy(sizes.data(), points.data(), 8);
  points.remove_prefix(8);
  const size_t length = header.points * header.point_bytes();
  if (sizes[1] != length) {
    return fail("decompresses to " + std::to_string(sizes[1]) + " bytes of points where " +
                std::to_string(length) + " are expected");
  }
  if (sizes[0] > points.size()) return fail("ends within its compressed points");
  // Three compressed bytes give at most 264: reject impossible lengths before allocating memory.
  if (length / 88 > sizes[0]) return fail("has compressed points that cannot be decompressed");
  std::vector<uint8_t> decompressed(length);
  if (!decompress_lzf({reinterpret_cast<const uint8_t*>(points.data()), sizes[0]}, decompressed)) {
    return fail("has compressed points that cannot be decompressed");
  }
  read_columns(reinterpret_cast<const char*>(decompressed.data()), header, field_indices, true,
               columns);
  return {};
}

/// Parses a number (NaN if out of range). Returns false if the word is not a number.
bool parse_value(std::string_view word, double& value) {
  const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (failed == std::errc::result_out_of_range) value = kNan;
  return failed != std::errc::invalid_argument && end == word.data() + word.size();
}

Result<void> read_ascii(std::string_view text, const PcdHeader& header,
                        const FieldIndices& field_indices, Columns& columns) {
  if (text.size() < 2 * header.points) return fail("ends within its points");
  for (size_t c = 0; c < field_indices.size(); ++c) {
    if (field_indices[c] >= 0) columns[c].resize(header.points);
  }
  for (size_t i = 0; i < header.points; ++i) {
    const size_t length = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, length);
    text.remove_prefix(std::min(length + 1, text.size()));
    for (size_t f = 0; f < header.fields.size(); ++f) {
      for (size_t k = 0; k < header.fields[f].count; ++k) {
        double value = 0;
        if (!parse_value(text::next_word(line), value)) {
          return fail("point " + std::to_string(i) + " has no number for " + header.fields[f].name);
        }
        for (size_t c = 0; c < field_indices.size(); ++c) {
          if (field_indices[c] == static_cast<int>(f)) columns[c][i] = value;
        }
      }
    }
  }
  return {};
}

/// Divisor that scales intensities to 0 … 1.
double find_intensity_scale(const std::vector<double>& intensity) {
  double max_intensity = 0;
  for (const double value : intensity)
    max_intensity = std::isfinite(value) ? std::max(max_intensity, value) : max_intensity;
  return max_intensity <= 1 ? 1 : max_intensity <= 255 ? 255 : 65535;
}

/// Whether returns were measured at different times: equal ones say nothing of them.
bool times_differ(std::span<const int32_t> offsets) {
  return std::ranges::adjacent_find(offsets, std::ranges::not_equal_to{}) != offsets.end();
}

/// Copies the points with the indices `order` to the sweep.
void fill_sweep(const Columns& columns, std::span<const uint32_t> order, Sweep& sweep) {
  sweep.clear();
  const bool has_times = !columns[kTime].empty();
  sweep.resize(order.size());
  const double scale = find_intensity_scale(columns[3]);
  for (size_t k = 0; k < order.size(); ++k) {
    const uint32_t i = order[k];
    const auto x = static_cast<float>(columns[0][i]);
    const auto y = static_cast<float>(columns[1][i]);
    const auto z = static_cast<float>(columns[2][i]);
    sweep.x[k] = x;
    sweep.y[k] = y;
    sweep.z[k] = z;
    sweep.range[k] = std::sqrt(x * x + y * y + z * z);
    const double intensity = columns[3].empty() ? 0 : columns[3][i];
    sweep.reflectivity[k] =
        std::isfinite(intensity) ? static_cast<float>(std::clamp(intensity / scale, 0.0, 1.0)) : 0;
    sweep.time_offset_ns[k] =
        has_times ? static_cast<int32_t>(std::nearbyint(columns[kTime][i])) : 0;
    sweep.return_kind[k] = ReturnKind::kStrongest;
  }
  sweep.has_times = times_differ(sweep.time_offset_ns);
}

/// Scales the times to nanoseconds after the sweep's stamp. Returns false if one of a point in
/// `order` is outside a turn.
bool scale_times(const TimeField& time, std::span<const uint32_t> order, Columns& columns) {
  if (columns[kTime].empty()) return true;
  for (double& value : columns[kTime]) value = (value - time.zero) * time.ns;
  constexpr auto kMaxNs = static_cast<double>(kMaxTurn.count());
  return std::ranges::all_of(
      order, [&](uint32_t i) { return columns[kTime][i] >= 0 && columns[kTime][i] <= kMaxNs; });
}

bool is_whole(double value, double end) {
  return value >= 0 && value < end && value == std::floor(value);
}

/// Fills rings, columns and kinds of the returns as the file states them. Returns false if it does
/// not, or not as `export_sweep` does.
bool keep_order(const Columns& columns, std::span<const uint32_t> order, Sweep& sweep) {
  constexpr double kMaxColumns = 65536;
  if (columns[kRing].empty() || columns[kKind].empty()) return false;
  for (const uint32_t i : order) {
    if (!is_whole(columns[kRing][i], kMaxRings) || !is_whole(columns[kColumn][i], kMaxColumns) ||
        !is_whole(columns[kKind][i], kReturnKinds))
      return false;
  }
  sweep.rings = 0;
  sweep.columns = 0;
  for (size_t k = 0; k < order.size(); ++k) {
    sweep.ring[k] = static_cast<uint16_t>(columns[kRing][order[k]]);
    sweep.column[k] = static_cast<uint16_t>(columns[kColumn][order[k]]);
    sweep.return_kind[k] = static_cast<ReturnKind>(columns[kKind][order[k]]);
    sweep.rings = std::max<uint16_t>(sweep.rings, static_cast<uint16_t>(sweep.ring[k] + 1));
    sweep.columns = std::max<uint32_t>(sweep.columns, sweep.column[k] + 1u);
  }
  return true;
}

bool is_return(const Columns& columns, size_t i) {
  float squared = 0;
  for (size_t c = 0; c < 3; ++c) {
    const auto coordinate = static_cast<float>(columns[c][i]);
    squared += coordinate * coordinate;
  }
  return std::isfinite(squared) && squared > 0;
}

/// Sorts the indices of the returns by ring from the top, and counter-clockwise from straight ahead
/// within a ring. Returns the start of each ring; empty if a ring number is not finite or there are
/// too many rings.
std::vector<size_t> sort_by_ring(const Columns& columns, std::vector<uint32_t>& order) {
  struct Ring {
    double sine = 0;  // of the elevation, summed
    size_t returns = 0;
    size_t from_top = 0;
  };
  std::map<double, Ring> rings;
  for (const uint32_t i : order) {
    if (!std::isfinite(columns[kRing][i])) return {};
    Ring& ring = rings[columns[kRing][i]];
    if (rings.size() > kMaxRings) return {};
    const double range = std::hypot(columns[0][i], columns[1][i], columns[2][i]);
    ring.sine += columns[2][i] / range;
    ++ring.returns;
  }
  std::vector<Ring*> from_top;
  for (auto& [name, ring] : rings) {
    ring.sine /= static_cast<double>(ring.returns);
    from_top.push_back(&ring);
  }
  std::stable_sort(from_top.begin(), from_top.end(),
                   [](const Ring* a, const Ring* b) { return a->sine > b->sine; });
  std::vector<size_t> starts{0};
  for (size_t k = 0; k < from_top.size(); ++k) {
    from_top[k]->from_top = k;
    starts.push_back(starts.back() + from_top[k]->returns);
  }
  std::vector<std::pair<size_t, double>> sort_key(columns[0].size());
  for (const uint32_t i : order) {
    const double azimuth = std::atan2(columns[1][i], columns[0][i]);
    sort_key[i] = {rings[columns[kRing][i]].from_top, azimuth < 0 ? azimuth + 2 * M_PI : azimuth};
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return sort_key[a] < sort_key[b]; });
  return starts;
}

}  // namespace

Result<void> parse_points(const PcdHeader& header, std::string_view points, Sweep& sweep,
                          const TimeField& time) {
  const FieldIndices field_indices = {
      header.find({"x"}),
      header.find({"y"}),
      header.find({"z"}),
      header.find({"intensity", "reflectivity", "reflectance", "i"}),
      header.find({"ring", "channel", "line", "laser_id", "laser", "beam"}),
      header.find({time.name}),
      header.find({"column"}),
      header.find({"return_kind"})};
  if (field_indices[0] < 0 || field_indices[1] < 0 || field_indices[2] < 0)
    return fail("has no fields x, y and z");
  if (header.points * header.point_bytes() > kMaxPointBytes) {
    return fail("has more than 256 MiB of points");
  }
  Columns columns;
  auto read = header.data == PcdData::kAscii ? read_ascii(points, header, field_indices, columns)
              : header.data == PcdData::kBinary
                  ? read_binary(points, header, field_indices, columns)
                  : read_compressed(points, header, field_indices, columns);
  if (!read) return read;
  std::vector<uint32_t> order;
  for (uint32_t i = 0; i < header.points; ++i) {
    if (is_return(columns, i)) order.push_back(i);
  }
  if (!scale_times(time, order, columns)) {
    return fail("has times of returns outside a turn", "", "expected 0 ... 2 s after its stamp");
  }
  if (!columns[kColumn].empty()) {
    fill_sweep(columns, order, sweep);
    if (keep_order(columns, order, sweep)) return {};
  }
  std::vector<size_t> rings;
  if (!columns[kRing].empty() && !order.empty()) rings = sort_by_ring(columns, order);
  fill_sweep(columns, order, sweep);
  if (rings.size() > 2 && assign_rings(sweep, rings)) return {};
  if (infer_rings(sweep) || restore_rings(sweep)) return {};
  if (!rings.empty()) assign_rings(sweep, rings);  // the one ring of a planar scanner
  return {};
}

std::vector<double> read_field(const PcdHeader& header, std::string_view points, size_t field) {
  if (points.size() < header.points * header.point_bytes()) return {};
  Columns columns;
  FieldIndices field_indices;
  field_indices.fill(-1);
  field_indices[0] = static_cast<int>(field);
  read_columns(points.data(), header, field_indices, false, columns);
  return std::move(columns[0]);
}

Result<void> parse_pcd_sweep(std::string_view bytes, Sweep& sweep) {
  const auto header = parse_pcd_header(bytes);
  if (!header) return tl::unexpected(header.error());
  return parse_points(*header, bytes.substr(header->data_offset), sweep);
}

}  // namespace infuse::recording
