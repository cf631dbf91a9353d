#include "drivers/recording/mapped_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "drivers/host/file_descriptor.hpp"
#include "drivers/host/system_error.hpp"

namespace infuse::recording {

using host::fail_errno;
using host::FileDescriptor;

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

}  // namespace infuse::recording
