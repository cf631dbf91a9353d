#include "daemon/owner/run_program.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>

namespace infuse::daemon {
namespace {

constexpr size_t kMaxOutput = size_t{8} << 20;

std::string read_all(int file) {
  std::string output;
  std::array<char, 4096> bytes;
  for (ssize_t count; (count = ::read(file, bytes.data(), bytes.size())) > 0;) {
    const size_t room = kMaxOutput - output.size();
    output.append(bytes.data(), std::min(room, static_cast<size_t>(count)));
  }
  return output;
}

}  // namespace

ProgramEnd run_program(const std::vector<std::string>& words) {
  ProgramEnd end;
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) return end;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, pipe[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, pipe[1], STDERR_FILENO);
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int failed =
      ::posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(pipe[1]);
  if (failed == 0) {
    end.output = read_all(pipe[0]);
    int status = 0;
    if (::waitpid(child, &status, 0) == child && WIFEXITED(status)) end.code = WEXITSTATUS(status);
  }
  ::close(pipe[0]);
  return end;
}

}  // namespace infuse::daemon
