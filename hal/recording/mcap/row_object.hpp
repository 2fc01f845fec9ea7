#pragma once
// Converts a row to a JSON object and back. Numbers are kept as texts, so that each comes back to
// the last digit; nlohmann's parser would convert them and lose the sign of -0.

#include <cstdint>
#include <string>
#include <string_view>

namespace smaservo::hal::mcap {

/// Whether the text is a number as JSON writes it.
bool is_json_number(std::string_view text);
/// Appends a text in quotes; false if it is not UTF-8.
bool put_json_text(std::string& to, std::string_view text);

/// One "name": value of an object.
struct Member {
  std::string_view name;
  /// A number is the text that stands there; a string is given without quotes and escapes; true and
  /// false are "1" and "0"; null is empty. Valid until the next member.
  std::string_view value;
};

/// Reads an object of numbers, strings, true, false and null.
class RowObject {
 public:
  explicit RowObject(std::string_view json) : json_(json) {}
  /// False at the end, or when problem() says what is wrong.
  bool next(Member& member);
  /// Empty if nothing is wrong; otherwise where and what: "at 12: ...".
  const std::string& problem() const { return problem_; }

 private:
  bool fail(std::string_view what);
  void skip_spaces();
  bool accept(char wanted);
  bool begin_member();
  bool value(std::string_view& to);
  bool number(std::string_view& to);
  bool word(std::string_view wanted);
  bool text(std::string_view& to, std::string& room);
  bool escape(std::string& to);
  bool four_digits(std::uint32_t& to);

  std::string_view json_;
  std::size_t at_ = 0;
  bool began_ = false;
  std::string name_, text_;  ///< buffers for texts whose escapes are replaced
  std::string problem_;
};

}  // namespace smaservo::hal::mcap
