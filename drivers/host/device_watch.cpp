#include "drivers/host/device_watch.hpp"

#include <sys/inotify.h>

#include <array>
#include <cstddef>
#include <cstring>

namespace infuse::host {

DeviceWatch::DeviceWatch(const std::vector<std::filesystem::path>& devices) {
  for (const std::filesystem::path& device : devices) {
    if (!device.is_absolute()) continue;
    for (auto path = device.lexically_normal(); path.has_relative_path();
         path = path.parent_path()) {
      names_.insert(path.filename());
      folders_.insert(path.parent_path());
    }
  }
  if (folders_.empty()) return;
  inotify_ = FileDescriptor(inotify_init1(IN_NONBLOCK | IN_CLOEXEC));
  watch_folders();
}

// Adding a watch that already exists has no effect.
void DeviceWatch::watch_folders() {
  for (const std::string& folder : folders_) {
    inotify_add_watch(inotify_.get(), folder.c_str(), IN_CREATE | IN_MOVED_TO | IN_ATTRIB);
  }
}

bool DeviceWatch::consume_changes() {
  alignas(inotify_event) std::array<char, 4096> events;
  bool relevant = false;
  while (true) {
    const ssize_t got = ::read(inotify_.get(), events.data(), events.size());
    if (got <= 0) break;
    const auto bytes = static_cast<size_t>(got);
    for (size_t at = 0; at + sizeof(inotify_event) <= bytes;) {
      inotify_event event{};
      std::memcpy(&event, events.data() + at, sizeof(event));
      const char* name = events.data() + at + sizeof(event);
      relevant =
          relevant || (event.mask & IN_Q_OVERFLOW) != 0 || (event.len > 0 && names_.contains(name));
      at += sizeof(event) + event.len;
    }
  }
  if (relevant) watch_folders();
  return relevant;
}

}  // namespace infuse::host
