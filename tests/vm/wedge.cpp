// vm-wedge TID SECONDS: suspends one thread of another process (ptrace), as if it were stuck.

#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const pid_t thread = std::atoi(argv[1]);
  if (ptrace(PTRACE_SEIZE, thread, nullptr, nullptr) != 0 ||
      ptrace(PTRACE_INTERRUPT, thread, nullptr, nullptr) != 0) {
    std::perror("vm-wedge");
    return 1;
  }
  waitpid(thread, nullptr, __WALL);
  // A killed thread disappears only after its tracer has waited for it.
  for (int tenths = 10 * std::atoi(argv[2]); tenths > 0; --tenths) {
    if (waitpid(thread, nullptr, __WALL | WNOHANG) != 0) return 0;
    usleep(100'000);
  }
  return 0;
}
