#pragma once

#include <chrono>
#include <string>

#include "drivers/measurement/error.hpp"

namespace infuse::ouster {

/// Asks a sensor for its metadata: `GET /api/v1/sensor/metadata` (firmware from 2.2 on). `host` is
/// an address or a name, with ":PORT" behind it if the port is not 80. Blocks for at most `timeout`
/// (the resolver of names aside). Errors: no answer in time, another status than 200, more than
/// 1 MiB.
Result<std::string> request_metadata(const std::string& host, std::chrono::milliseconds timeout);

}  // namespace infuse::ouster
