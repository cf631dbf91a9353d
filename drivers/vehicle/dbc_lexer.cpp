#include "drivers/vehicle/dbc_lexer.hpp"

#include <algorithm>
#include <array>

namespace infuse::vehicle {
namespace {

constexpr std::array<std::string_view, 35> kKeywords = {
    "VERSION",       "NS_",           "BS_",
    "BU_",           "BO_",           "SG_",
    "EV_",           "ENVVAR_DATA_",  "SGTYPE_",
    "SGTYPE_VAL_",   "BO_TX_BU_",     "CM_",
    "BA_DEF_",       "BA_",           "VAL_",
    "CAT_DEF_",      "CAT_",          "FILTER",
    "BA_DEF_DEF_",   "EV_DATA_",      "BA_SGTYPE_",
    "SIG_TYPE_REF_", "VAL_TABLE_",    "SIG_GROUP_",
    "SIG_VALTYPE_",  "NS_DESC_",      "SIGTYPE_VALTYPE_",
    "BA_DEF_REL_",   "BA_REL_",       "BA_DEF_DEF_REL_",
    "BU_SG_REL_",    "BU_EV_REL_",    "BU_BO_REL_",
    "SG_MUL_VAL_",   "BA_DEF_SGTYPE_"};

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

/// True if the text after a line's end looks like a new statement: the string before it was never
/// closed.
bool starts_statement(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return false;
  size_t end = begin;
  while (end < text.size() && is_letter(text[end])) ++end;
  return end < text.size() && (text[end] == ' ' || text[end] == '\t') &&
         text[end - (end > begin ? 1 : 0)] == '_' &&
         is_dbc_keyword(text.substr(begin, end - begin));
}

}  // namespace

bool is_dbc_keyword(std::string_view word) {
  return std::find(kKeywords.begin(), kKeywords.end(), word) != kKeywords.end();
}

DbcLexer::DbcLexer(std::string_view text) : text_(text) {
  if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
  lookahead_ = read();
}

DbcToken DbcLexer::next() {
  DbcToken taken = lookahead_;
  lookahead_ = read();
  return taken;
}

void DbcLexer::skip_space() {
  while (position_ < text_.size() && static_cast<unsigned char>(text_[position_]) <= ' ') {
    if (text_[position_] == '\n') {
      ++line_;
      first_on_line_ = true;
    }
    ++position_;
  }
}

DbcToken DbcLexer::read() {
  DbcToken token = read_token();
  const size_t following = text_.find_first_not_of(" \t\r", position_);
  token.last_on_line = following == std::string_view::npos || text_[following] == '\n';
  return token;
}

DbcToken DbcLexer::read_token() {
  skip_space();
  DbcToken token;
  token.line = line_;
  token.first_on_line = first_on_line_;
  first_on_line_ = false;
  if (position_ >= text_.size()) return token;
  const char c = text_[position_];
  const char following = position_ + 1 < text_.size() ? text_[position_ + 1] : '\0';
  if (c == '"') return read_string(token);
  const size_t begin = position_++;
  if (is_letter(c)) {
    token.kind = DbcToken::Kind::kWord;
    while (position_ < text_.size() && (is_letter(text_[position_]) || is_digit(text_[position_])))
      ++position_;
  } else if (is_digit(c) || ((c == '-' || c == '+' || c == '.') &&
                             (is_digit(following) || (c != '.' && following == '.')))) {
    token.kind = DbcToken::Kind::kNumber;
    while (position_ < text_.size()) {
      const char d = text_[position_];
      const char previous = text_[position_ - 1];
      const bool exponent_sign = (d == '-' || d == '+') && (previous == 'e' || previous == 'E');
      if (!is_digit(d) && d != '.' && d != 'e' && d != 'E' && !exponent_sign) break;
      ++position_;
    }
  } else {
    token.kind = DbcToken::Kind::kPunctuation;
  }
  token.text = text_.substr(begin, position_ - begin);
  return token;
}

DbcToken DbcLexer::read_string(DbcToken token) {
  const size_t begin = ++position_;
  size_t first_line_end = std::string_view::npos;
  for (size_t i = begin; i < text_.size(); ++i) {
    if (text_[i] == '\\' && i + 1 < text_.size() && text_[i + 1] == '"') {
      ++i;
    } else if (text_[i] == '"') {
      token.kind = DbcToken::Kind::kString;
      token.text = text_.substr(begin, i - begin);
      line_ += static_cast<int>(std::count(token.text.begin(), token.text.end(), '\n'));
      position_ = i + 1;
      return token;
    } else if (text_[i] == '\n') {
      if (first_line_end == std::string_view::npos) first_line_end = i;
      if (starts_statement(text_.substr(i + 1, 64))) break;
    }
  }
  token.kind = DbcToken::Kind::kUnterminatedString;
  position_ = std::min(first_line_end, text_.size());
  token.text = text_.substr(begin, position_ - begin);
  return token;
}

}  // namespace infuse::vehicle
