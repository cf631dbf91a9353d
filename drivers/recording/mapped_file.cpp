#include "drivers/recording/mapped_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "drivers/receive/file_descriptor.hpp"
#include "drivers/receive/system_error.hpp"

namespace infuse::recording {
namespace {

using receive::fail_errno;
using receive::FileDescriptor;

bool write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return true;
}

}  // namespace

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

Result<MappedFile> MappedFile::open(const std::filesystem::path& path) {
  // O_NONBLOCK: opening a pipe must not block; it is rejected below.
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file) return fail_errno("cannot be opened", path.string());
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return fail_errno("cannot be read", path.string());
  if (!S_ISREG(status.st_mode)) return fail("is not a regular file", path.string());
  if (status.st_size <= 0) return fail("is empty", path.string());
  const auto size = static_cast<size_t>(status.st_size);
  void* memory = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.get(), 0);
  if (memory == MAP_FAILED) return fail_errno("cannot be mapped", path.string());
  MappedFile mapped;
  mapped.bytes_ = {static_cast<const std::byte*>(memory), size};
  return mapped;
}

Result<void> write_file_atomically(const std::filesystem::path& path,
                                   std::span<const std::byte> bytes) {
  std::string temporary = path.string() + ".XXXXXX";
  const FileDescriptor file(::mkostemp(temporary.data(), O_CLOEXEC));
  if (!file) {
    return fail_errno("cannot be written", path.string(),
                      "does the folder exist, and is it writable?");
  }
  const bool succeeded = ::fchmod(file.get(), 0644) == 0 && write_all(file.get(), bytes) &&
                         ::fsync(file.get()) == 0 && ::rename(temporary.c_str(), path.c_str()) == 0;
  if (succeeded) return {};
  const int reason = errno;
  ::unlink(temporary.c_str());
  return fail_errno("cannot be written", path.string(), "is the disk full?", reason);
}

}  // namespace infuse::recording
