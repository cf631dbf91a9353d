#pragma once

#include <string>
#include <tl/expected.hpp>

namespace infuse {

/// A failure at an edge (bytes, files, sockets, configuration), described so that a person can act
/// on it.
struct Error {
  std::string what;   ///< what is wrong: "unknown key 'modle'"
  std::string where;  ///< file, line, offset, address: "drive.toml:12"; empty if there is none
  std::string
      hint;  ///< what to do: "known keys: model, port, sender"; empty if there is nothing to add

  /// Returns "where: what (hint)" without the empty parts.
  std::string message() const {
    return (where.empty() ? "" : where + ": ") + what + (hint.empty() ? "" : " (" + hint + ")");
  }
};

/// A value, or the error that prevented it.
template <class T>
using Result = tl::expected<T, Error>;

/// Shorthand for `return fail(what, where, hint)` in a function that returns a Result.
inline tl::unexpected<Error> fail(std::string what, std::string where = {}, std::string hint = {}) {
  return tl::unexpected<Error>(Error{std::move(what), std::move(where), std::move(hint)});
}

}  // namespace infuse
