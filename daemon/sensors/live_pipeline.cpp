#include "daemon/sensors/live_pipeline.hpp"

#include <spdlog/spdlog.h>

#include "daemon/pipeline/threads.hpp"

namespace infuse::daemon {
namespace {

constexpr int kIoPriority = 10;

}  // namespace

LivePipeline::LivePipeline(boost::asio::io_context& io, SensorSetup setup,
                           const PipelineOptions& options, Server& server,
                           std::function<void()> on_end, const host::TimeBase& base, RecordTap* tap)
    : setup_(std::move(setup)), pipeline_(io, setup_, options, server, nullptr, std::move(on_end)) {
  reader_.emplace(setup_, pipeline_.intake(), base, tap);
}

void LivePipeline::start() {
  if (!lock_memory()) spdlog::info("memory is not locked: not permitted");
  pipeline_.start([this](std::stop_token stop) {
    if (!make_real_time(kIoPriority)) {
      spdlog::info("the io thread has no real-time priority: not permitted");
    }
    reader_->run(stop);
  });
}

}  // namespace infuse::daemon
