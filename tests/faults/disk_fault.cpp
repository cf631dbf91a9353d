// A library that stands before the C library, linked or preloaded: what a program changes in a
// folder fails with the error number in that folder's, or a higher folder's, file .disk-fault
// (disk_fault.hpp). Reading goes on.

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

constexpr const char* kControl = "/.disk-fault";

/// The function of that name in the library behind this one.
template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

/// The error number in a control file; 0 if there is none.
int number_in(const std::string& file) {
  const auto fd = static_cast<int>(syscall(SYS_openat, AT_FDCWD, file.c_str(), O_RDONLY));
  if (fd < 0) return 0;
  char text[8] = {};
  syscall(SYS_read, fd, text, sizeof(text) - 1);
  syscall(SYS_close, fd);
  return std::atoi(text);
}

/// The error with which a change of the file fails; 0 if it does not.
int fault_of(std::string path) {
  const int before = errno;
  int fault = 0;
  if (!path.ends_with(kControl)) {
    while (fault == 0 && path.find('/') != std::string::npos) {
      path.resize(path.rfind('/'));
      fault = number_in(path + kControl);
    }
  }
  errno = before;
  return fault;
}

int fault_of(int file) {
  char name[4096];
  const std::string link = "/proc/self/fd/" + std::to_string(file);
  const ssize_t size = readlink(link.c_str(), name, sizeof(name));
  return size <= 0 || name[0] != '/' ? 0 : fault_of(std::string(name, static_cast<size_t>(size)));
}

/// On a full disk what is there can be opened; on one that is read-only nothing can for writing.
int opening_fault(const char* path, int flags) {
  if ((flags & O_ACCMODE) == O_RDONLY && (flags & O_CREAT) == 0) return 0;
  const int fault = fault_of(path);
  if (fault == EROFS) return fault;
  return (flags & O_CREAT) != 0 && access(path, F_OK) != 0 ? fault : 0;
}

/// Of a change that takes no space: a full disk lets it pass.
template <class File>
int lasting_fault_of(File file) {
  const int fault = fault_of(file);
  return fault == ENOSPC ? 0 : fault;
}

/// A full disk lets what is there be replaced.
int writing_fault(int file, off_t at, size_t size) {
  const int fault = fault_of(file);
  struct stat about {};
  if (fault != ENOSPC || fstat(file, &about) != 0) return fault;
  return at + static_cast<off_t>(size) <= about.st_size ? 0 : fault;
}

bool fails(int fault) {
  if (fault != 0) errno = fault;
  return fault != 0;
}

mode_t mode_of(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

}  // namespace

// NOLINTBEGIN(readability-inconsistent-declaration-parameter-name)
extern "C" {

#define OPEN(name)                                                              \
  int name(const char* path, int flags, ...) {                                  \
    va_list arguments;                                                          \
    va_start(arguments, flags);                                                 \
    const mode_t mode = mode_of(flags, arguments);                              \
    va_end(arguments);                                                          \
    return fails(opening_fault(path, flags))                                    \
               ? -1                                                             \
               : next<int(const char*, int, mode_t)>(#name)(path, flags, mode); \
  }
OPEN(open)
OPEN(open64)

#define WRITE(name, at, parameters, arguments)                                                  \
  ssize_t name parameters {                                                                     \
    return fails(writing_fault(fd, at, size)) ? -1 : next<ssize_t parameters>(#name) arguments; \
  }
WRITE(write, lseek(fd, 0, SEEK_CUR), (int fd, const void* bytes, size_t size), (fd, bytes, size))
WRITE(pwrite, at, (int fd, const void* bytes, size_t size, off_t at), (fd, bytes, size, at))
WRITE(pwrite64, at, (int fd, const void* bytes, size_t size, off64_t at), (fd, bytes, size, at))

#define CHANGE(result, name, subject, parameters, arguments)                         \
  result name parameters {                                                           \
    return fails(fault_of(subject)) ? -1 : next<result parameters>(#name) arguments; \
  }
CHANGE(ssize_t, writev, fd, (int fd, const iovec* parts, int count), (fd, parts, count))
CHANGE(int, fallocate, fd, (int fd, int mode, off_t at, off_t size), (fd, mode, at, size))
CHANGE(int, mkdir, path, (const char* path, mode_t mode), (path, mode))
CHANGE(int, mkostemp, path, (char* path, int flags), (path, flags))

// These take no space.
#define SYNC(name, parameters, arguments)                                            \
  int name parameters {                                                              \
    return fails(lasting_fault_of(fd)) ? -1 : next<int parameters>(#name) arguments; \
  }
SYNC(fsync, (int fd), (fd))
SYNC(fdatasync, (int fd), (fd))
SYNC(ftruncate, (int fd, off_t size), (fd, size))
SYNC(ftruncate64, (int fd, off64_t size), (fd, size))

/// C's own streams write inside the C library: they fail when they are opened.
#define STREAM(name)                                                                       \
  FILE* name(const char* path, const char* mode) {                                         \
    const bool reads = mode[0] == 'r' && std::string(mode).find('+') == std::string::npos; \
    if (!reads && fails(fault_of(std::string(path)))) return nullptr;                      \
    return next<FILE*(const char*, const char*)>(#name)(path, mode);                       \
  }
STREAM(fopen)
STREAM(fopen64)

int rename(const char* from, const char* to) {
  return fails(lasting_fault_of(to)) ? -1 : next<int(const char*, const char*)>("rename")(from, to);
}
int unlink(const char* path) {
  return fails(lasting_fault_of(path)) ? -1 : next<int(const char*)>("unlink")(path);
}

}  // extern "C"
// NOLINTEND(readability-inconsistent-declaration-parameter-name)
