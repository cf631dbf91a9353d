#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace infuse::vehicle {

/// A word, number, string or sign of a DBC file.
struct DbcToken {
  enum class Kind { kEnd, kWord, kNumber, kString, kPunctuation, kUnterminatedString };
  Kind kind = Kind::kEnd;
  std::string_view text;       ///< for a string, without its quotes
  int line = 0;                ///< counted from 1
  bool first_on_line = false;  ///< preceded only by space
  bool last_on_line = false;   ///< followed only by space

  /// True if the token is this word or sign.
  bool is(std::string_view wanted) const {
    return (kind == Kind::kWord || kind == Kind::kPunctuation) && text == wanted;
  }
};

/// Splits the text of a DBC file into tokens. An unclosed string becomes a broken token that ends
/// with its line, so that it does not swallow the following text.
class DbcLexer {
 public:
  explicit DbcLexer(std::string_view text);

  /// The next token, without consuming it.
  const DbcToken& peek() const { return lookahead_; }

  /// Consumes and returns the next token.
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

/// True if the word opens a statement of a DBC file.
bool is_dbc_keyword(std::string_view word);

}  // namespace infuse::vehicle
