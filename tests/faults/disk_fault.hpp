#pragma once

#include <filesystem>
#include <fstream>

namespace infuse {

/// While it exists, every change of a file in a folder, or below it, fails: ENOSPC, EIO or EROFS.
/// Needs the library `disk_fault`, linked to the test or preloaded into a program.
class DiskFault {
 public:
  DiskFault(const std::filesystem::path& folder, int error) : control_(folder / ".disk-fault") {
    std::ofstream(control_) << error;
  }
  ~DiskFault() {
    std::error_code ignored;
    std::filesystem::remove(control_, ignored);
  }
  DiskFault(const DiskFault&) = delete;
  DiskFault& operator=(const DiskFault&) = delete;

 private:
  std::filesystem::path control_;
};

}  // namespace infuse
