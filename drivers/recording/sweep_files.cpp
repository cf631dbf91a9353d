#include "drivers/recording/sweep_files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <string>

#include "drivers/host/file_descriptor.hpp"
#include "drivers/host/system_error.hpp"
#include "drivers/recording/pcd_sweep.hpp"
#include "drivers/recording/ply_sweep.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::recording {
namespace {

static_assert(std::endian::native == std::endian::little, "sweep files are little-endian");

constexpr size_t kPointBytes = 16;
constexpr size_t kMaxSweepBytes = 64 << 20;

Result<void> read_points(const std::filesystem::path& path, Sweep& sweep) {
  const auto bytes = text::read_text(path, kMaxSweepBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  auto parsed =
      path.extension() == ".ply" ? parse_ply_sweep(*bytes, sweep) : parse_pcd_sweep(*bytes, sweep);
  if (parsed) return parsed;
  const Error& wrong = parsed.error();
  const std::string line = wrong.where.empty() ? "" : ", " + wrong.where;
  return fail(wrong.what, path.string() + line, wrong.hint);
}

}  // namespace

Result<void> SweepReader::load(const std::filesystem::path& path) {
  const host::FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat status {};
  if (!file || ::fstat(file.get(), &status) != 0) {
    return host::fail_errno("cannot be read", path.string());
  }
  if (!S_ISREG(status.st_mode)) return fail("is not a regular file", path.string());
  const auto length = static_cast<size_t>(status.st_size);
  if (length > kMaxSweepBytes) return fail("is longer than 64 MiB", path.string());
  if (length % kPointBytes != 0) {
    return fail("is " + std::to_string(length) + " bytes long, which is not a multiple of 16",
                path.string(), "expected float32 x y z reflectance");
  }
  points_.resize(length / kPointBytes);
  auto* bytes = reinterpret_cast<char*>(points_.data());
  for (size_t done = 0; done < length;) {
    const ssize_t bytes_read = ::read(file.get(), bytes + done, length - done);
    if (bytes_read < 0 && errno == EINTR) continue;
    if (bytes_read < 0) return host::fail_errno("cannot be read", path.string());
    if (bytes_read == 0) return fail("was truncated while being read", path.string());
    done += static_cast<size_t>(bytes_read);
  }
  return {};
}

Result<void> SweepReader::read(const std::filesystem::path& path, Sweep& sweep) {
  if (path.extension() == ".pcd" || path.extension() == ".ply") return read_points(path, sweep);
  if (auto loaded = load(path); !loaded) return loaded;
  sweep.clear();
  sweep.has_times = false;
  sweep.resize(points_.size());
  size_t count = 0;
  for (const auto& [x, y, z, reflectance] : points_) {
    const float range = std::sqrt(x * x + y * y + z * z);
    if (!std::isfinite(range) || !std::isfinite(reflectance)) continue;
    sweep.x[count] = x;
    sweep.y[count] = y;
    sweep.z[count] = z;
    sweep.range[count] = range;
    sweep.reflectivity[count] = reflectance;
    sweep.time_offset_ns[count] = 0;
    sweep.return_kind[count] = ReturnKind::kStrongest;
    ++count;
  }
  sweep.resize(count);
  if (!infer_rings(sweep)) restore_rings(sweep);
  return {};
}

void SweepReader::reserve(size_t points, Sweep& sweep) {
  points_.reserve(points);
  sweep.reserve(points);
}

Result<void> read_sweep_file(const std::filesystem::path& path, Sweep& sweep) {
  return SweepReader().read(path, sweep);
}

Result<void> write_sweep_bin(const std::filesystem::path& path, const Sweep& sweep) {
  std::string bytes(sweep.size() * kPointBytes, '\0');
  for (size_t i = 0; i < sweep.size(); ++i) {
    const std::array<float, 4> point = {sweep.x[i], sweep.y[i], sweep.z[i], sweep.reflectivity[i]};
    std::memcpy(&bytes[i * kPointBytes], point.data(), kPointBytes);
  }
  return text::write_text(path, bytes);
}

}  // namespace infuse::recording
