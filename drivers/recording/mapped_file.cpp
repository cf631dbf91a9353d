#include "drivers/recording/mapped_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace infuse::recording {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

std::string errno_message(const char* what) {
  return std::string(what) + ": " + std::strerror(errno);
}

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
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.number() < 0) return fail(errno_message("cannot be opened"), path.string());
  struct stat status {};
  if (::fstat(file.number(), &status) != 0)
    return fail(errno_message("cannot be read"), path.string());
  if (!S_ISREG(status.st_mode)) return fail("is not a regular file", path.string());
  if (status.st_size <= 0) return fail("is empty", path.string());
  const auto size = static_cast<size_t>(status.st_size);
  void* memory = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.number(), 0);
  if (memory == MAP_FAILED) return fail(errno_message("cannot be mapped"), path.string());
  MappedFile mapped;
  mapped.bytes_ = {static_cast<const std::byte*>(memory), size};
  return mapped;
}

Result<void> write_file_atomically(const std::filesystem::path& path,
                                   std::span<const std::byte> bytes) {
  std::string temporary = path.string() + ".XXXXXX";
  const Descriptor file(::mkostemp(temporary.data(), O_CLOEXEC));
  if (file.number() < 0) {
    return fail(errno_message("cannot be written"), path.string(),
                "does the folder exist, and is it writable?");
  }
  const bool succeeded = ::fchmod(file.number(), 0644) == 0 && write_all(file.number(), bytes) &&
                         ::fsync(file.number()) == 0 &&
                         ::rename(temporary.c_str(), path.c_str()) == 0;
  if (succeeded) return {};
  const std::string message = errno_message("cannot be written");
  ::unlink(temporary.c_str());
  return fail(message, path.string(), "is the disk full?");
}

}  // namespace infuse::recording
