#pragma once
// A person who answers questions by a script.

#include <deque>
#include <string>
#include <vector>

#include "host-sim/commission/live/questions.hpp"

namespace smaservo::commission {

class ScriptedPerson final : public Person {
 public:
  bool is_there() override { return there; }
  void show(std::string_view line) override {
    longest_line = std::max(longest_line, line.size());
    ++shown;
  }
  void say(std::string_view line) override { said.emplace_back(line); }
  void ask(std::string_view question, std::int64_t /*until_us*/) override {
    asked.emplace_back(question);
    waits = false;
  }
  /// Each question gets the next answer; without one, silence.
  std::optional<std::string> typed() override {
    if (waits || answers.empty()) {
      return {};
    }
    waits = true;
    std::string answer = answers.front();
    answers.pop_front();
    return answer == silence ? std::nullopt : std::optional(answer);
  }

  static constexpr const char* silence = "(silence)";
  std::deque<std::string> answers;
  std::vector<std::string> said, asked;
  bool there = true, waits = false;
  std::size_t shown = 0, longest_line = 0;
};

}  // namespace smaservo::commission
