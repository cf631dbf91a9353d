#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "drivers/vehicle/dbc_lexer.hpp"

namespace infuse::vehicle {

/// Reads a statement of a DBC file token by token. What is wrong first is kept as a value: from
/// then on nothing is consumed, and every read returns an empty token or 0.
class DbcStatement {
 public:
  explicit DbcStatement(std::string_view text) : lexer_(text) {}

  /// Consumes and returns the token that opens a statement; the error before is forgotten.
  DbcToken open();

  /// The next token.
  const DbcToken& peek() const { return lexer_.peek(); }

  /// True if nothing was wrong since the statement was opened.
  bool ok() const { return !error_; }

  /// What was wrong.
  const std::optional<std::string>& error() const { return error_; }

  /// Says what is wrong, unless something was wrong before.
  void fail(std::string what);

  /// Consumes the next token.
  DbcToken next();

  /// Consumes the next token if it is this one; true if it was.
  bool accept(std::string_view sign);

  /// Consumes a token that must be of a kind.
  DbcToken expect(DbcToken::Kind kind, const char* what);

  /// Consumes a token that must be this one.
  void expect(std::string_view sign);

  double number(const char* what);
  uint64_t whole_number(const char* what);

  /// VERSION "x", BS_: and BU_: a b end with their lines; the words under NS_: are alone on their
  /// lines.
  void skip_lines();
  void skip_rest_of_line();
  void skip_to_semicolon();

  /// Goes on after an error: to what opens the next statement.
  void skip_to_next();

 private:
  DbcLexer lexer_;
  std::optional<std::string> error_;
};

}  // namespace infuse::vehicle
