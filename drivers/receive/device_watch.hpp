#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "drivers/receive/file_descriptor.hpp"

namespace infuse::receive {

/// Tells when a device that was away may have come (inotify): its name, or a folder on the way to
/// it, appears or gets another owner. That is what udev does for a device that is plugged in, its
/// own links included.
class DeviceWatch {
 public:
  /// Watches for these, absolute paths. Where the kernel refuses, nothing is ever told.
  explicit DeviceWatch(const std::vector<std::filesystem::path>& devices);

  /// Readable when something has changed; −1 where nothing is watched.
  int descriptor() const { return inotify_.get(); }

  /// Takes all that waits. Whether any of it was about the devices.
  bool consume_changes();

 private:
  void watch_folders();

  FileDescriptor inotify_;
  std::set<std::string> folders_;  // that lead to the devices, whether they are there or not
  std::set<std::string> names_;    // of the devices and of these folders
};

}  // namespace infuse::receive
