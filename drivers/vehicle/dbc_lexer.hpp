#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace infuse::vehicle {

/// A word, number, string or sign of a DBC file.
struct DbcToken {
  enum class Kind { kEnd, kWord, kNumber, kString, kPunctuation, kUnterminatedString };
  Kind kind = Kind::kEnd;
  std::string_view text;       ///< of a string, without its quotes
  int line = 0;                ///< from 1
  bool first_on_line = false;  ///< nothing but space before it
  bool last_on_line = false;   ///< nothing but space after it

  /// It is this word or sign.
  bool is(std::string_view wanted) const {
    return (kind == Kind::kWord || kind == Kind::kPunctuation) && text == wanted;
  }
};

/// Cuts the text of a DBC file into tokens. A string that is not closed becomes a broken token that
/// ends with its line, so that it does not swallow what follows.
class DbcLexer {
 public:
  explicit DbcLexer(std::string_view text);

  /// The token ahead.
  const DbcToken& peek() const { return lookahead_; }

  /// Takes the token ahead.
  DbcToken next();

 private:
  DbcToken read();
  DbcToken read_token();
  void skip_space();
  DbcToken read_string(DbcToken token);

  std::string_view text_;
  size_t position_ = 0;
  int line_ = 1;
  bool first_on_line_ = true;
  DbcToken lookahead_;
};

/// A word that opens a statement of a DBC file.
bool is_dbc_keyword(std::string_view word);

}  // namespace infuse::vehicle
