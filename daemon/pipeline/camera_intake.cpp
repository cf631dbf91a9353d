#include "daemon/pipeline/camera_intake.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace infuse::daemon {
namespace {

/// Reads a regular file of at most `max_bytes`; does not allocate once `bytes` has been as large.
bool read_file(const char* path, size_t max_bytes, std::vector<uint8_t>& bytes) {
  const int file = ::open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return false;
  struct stat status {};
  bool whole = ::fstat(file, &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0 &&
               static_cast<size_t>(status.st_size) <= max_bytes;
  if (whole) {
    bytes.resize(static_cast<size_t>(status.st_size));
    size_t at = 0;
    while (at < bytes.size()) {
      const ssize_t got = ::read(file, bytes.data() + at, bytes.size() - at);
      if (got <= 0) break;
      at += static_cast<size_t>(got);
    }
    whole = at == bytes.size();
  }
  ::close(file);
  return whole;
}

}  // namespace

bool CameraIntake::read_image(Stamp stamp, uint64_t sequence, const std::filesystem::path& path,
                              std::vector<uint8_t>& encoded) {
  count(stamp, sequence);
  if (read_file(path.c_str(), kMaxBytes, encoded)) return true;
  ++counters_.refused;
  return false;
}

void CameraIntake::count(Stamp stamp, uint64_t sequence) {
  if (sequence > next_) counters_.lost += sequence - next_;
  next_ = sequence + 1;
  counters_.count(stamp);
}

}  // namespace infuse::daemon
