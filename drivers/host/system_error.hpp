#pragma once

#include <cerrno>
#include <string>
#include <system_error>

#include "drivers/measurement/error.hpp"

namespace infuse::host {

/// Returns a failed system call as an `Error`: "what: Permission denied". `number` is its errno.
inline tl::unexpected<Error> fail_errno(const std::string& what, const std::string& where,
                                        std::string hint = {}, int number = errno) {
  return fail(what + ": " + std::generic_category().message(number), where, std::move(hint));
}

}  // namespace infuse::host
