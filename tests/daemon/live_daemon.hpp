#pragma once

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>

#include "tests/daemon/run_program.hpp"
#include "tests/folders.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {

/// A live daemon without sensors, whose state directory (`state`) can fail: tests/faults.
class LiveDaemon {
 public:
  /// Writes `folder`/infused.toml and starts with it; `mcap`: the file of --mcap, if any.
  LiveDaemon(const ScratchFolder& folder, const std::string& configuration,
             const char* mcap = nullptr)
      : folder_(folder) {
    std::filesystem::create_directories(folder / "state");
    folder.write("infused.toml", configuration);
    const std::string program = programs_folder() + "/infused";
    const std::string preload = "LD_PRELOAD=" + programs_folder() + "/libdisk_fault.so";
    const std::string state = "STATE_DIRECTORY=" + (folder / "state").string();
    const std::string config = (folder / "infused.toml").string(), socket = socket_path();
    process_ = fork();
    if (process_ != 0) return;
    static_cast<void>(std::freopen((folder / "log").c_str(), "w", stderr));
    ::execlp("env", "env", "ASAN_OPTIONS=verify_asan_link_order=0", preload.c_str(), state.c_str(),
             program.c_str(), "--config", config.c_str(), "--socket", socket.c_str(),
             mcap == nullptr ? nullptr : "--mcap", mcap, nullptr);
    ::_exit(127);
  }
  ~LiveDaemon() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  LiveDaemon(const LiveDaemon&) = delete;
  LiveDaemon& operator=(const LiveDaemon&) = delete;

  pid_t process() const { return process_; }

  std::string status() const {
    return run_shell_command(programs_folder() + "/infuse status --socket " + socket_path() +
                             " 2>&1")
        .output;
  }
  /// Waits until the status holds a text; returns the last one.
  std::string wait_for(const std::string& text) const {
    std::string last;
    for (int k = 0; k < 150 && last.find(text) == std::string::npos; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      last = status();
    }
    return last;
  }
  /// Exit code; -1 if it did not exit by itself.
  int stop() {
    kill(process_, SIGTERM);
    int code = 0;
    waitpid(std::exchange(process_, -1), &code, 0);
    return WIFEXITED(code) ? WEXITSTATUS(code) : -1;
  }

 private:
  std::string socket_path() const { return (folder_ / "s").string(); }

  const ScratchFolder& folder_;
  pid_t process_ = -1;
};

}  // namespace infuse::daemon
