#include <spdlog/spdlog.h>

// spdlog makes its logger when it is first requested one, inside a library that the thread
// sanitizer does not see into: two threads that log for the first time would look like a race. The
// daemon sets its log level before it starts a thread; this does the same for the test programs.
[[maybe_unused]] static const auto* const early_logger = spdlog::default_logger_raw();
