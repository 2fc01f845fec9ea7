#pragma once

#include "host-sim/commission/live/questions.hpp"

namespace smaservo::commission {

/// The person at this program's terminal: asked on the standard error output, answers on the
/// standard input. Nobody is there if either is no terminal, or once the input has ended.
class TerminalPerson final : public Person {
 public:
  /// `questions`: false if nothing is to be asked in any case.
  explicit TerminalPerson(bool questions);
  ~TerminalPerson() override { end_line(); }
  TerminalPerson(const TerminalPerson&) = delete;
  TerminalPerson& operator=(const TerminalPerson&) = delete;

  bool is_there() override { return is_there_; }
  void show(std::string_view line) override;
  void say(std::string_view line) override;
  void ask(std::string_view question, std::int64_t until_us) override;
  std::optional<std::string> typed() override;

 private:
  void end_line();

  bool is_there_;
  bool draws_;         ///< the standard error output is a terminal
  bool open_ = false;  ///< the last line has no end yet
  std::string input_;
};

}  // namespace smaservo::commission
