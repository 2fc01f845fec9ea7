#pragma once
// What is asked of a simulated device: set-points over time, as a scenario's [[command]] tables
// say.

#include <cstdint>
#include <random>
#include <vector>

#include "firmware/command.hpp"

namespace smaservo::files {
class TomlTable;
}  // namespace smaservo::files

namespace smaservo::bench {

/// One mode for some time. The set-point goes on a straight line, with a sine on it where asked.
struct CommandStretch {
  Command<double> command;  ///< the set-point is the line's beginning
  double seconds;
  double end;  ///< of the line
  double amplitude = 0;
  double from_Hz = 0, to_Hz = 0;  ///< the frequency grows exponentially
  bool silent = false;            ///< the command source says nothing: no command is fresh
};

/// Reads all of them; random ones are drawn. Throws UserError.
std::vector<CommandStretch> read_commands(std::vector<files::TomlTable> tables,
                                          std::mt19937_64& random);

/// The stretches one after the other; the last one's end holds on.
class CommandProgram {
 public:
  explicit CommandProgram(std::vector<CommandStretch> stretches);

  /// Times must not go back.
  Command<double> at(double time_s);
  double duration_s() const { return duration_s_; }

 private:
  std::vector<CommandStretch> stretches_;
  std::size_t now_ = 0;
  double began_s_ = 0;
  double duration_s_ = 0;
};

}  // namespace smaservo::bench
