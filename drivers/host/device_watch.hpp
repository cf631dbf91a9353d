#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "drivers/host/file_descriptor.hpp"

namespace infuse::host {

/// Reports that a missing device may have appeared (inotify): its name, or a folder on the path to
/// it, appears or changes owner. udev causes both for a device that is plugged in, including udev's
/// own links.
class DeviceWatch {
 public:
  /// Watches for these devices, absolute paths. If the kernel refuses, nothing is ever reported.
  explicit DeviceWatch(const std::vector<std::filesystem::path>& devices);

  /// Readable when something has changed; −1 if nothing is watched.
  int descriptor() const { return inotify_.get(); }

  /// Consumes all pending events. True if any of them concerns the devices.
  bool consume_changes();

 private:
  void watch_folders();

  FileDescriptor inotify_;
  std::set<std::string> folders_;  // on the paths to the devices, existing or not
  std::set<std::string> names_;    // of the devices and of these folders
};

}  // namespace infuse::host
