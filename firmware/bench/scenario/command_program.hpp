#pragma once
// The commands to a simulated device: set-points over time, from a scenario's [[command]] tables.

#include <cstdint>
#include <random>
#include <vector>

#include "firmware/command.hpp"

namespace smaservo::files {
class TomlTable;
}  // namespace smaservo::files

namespace smaservo::bench {

/// One mode for some time. The set-point follows a straight line, with a sine of `amplitude` added
/// to it.
struct CommandStretch {
  Command<double> command;  ///< its set-point begins the line
  double seconds;
  double end;  ///< the line's last set-point
  double amplitude = 0;
  double from_Hz = 0, to_Hz = 0;  ///< the frequency grows exponentially
  bool silent = false;            ///< no command is fresh, as without a source
};

/// Makes the stretches of all tables; random ones are drawn from `random`. Throws UserError.
std::vector<CommandStretch> read_commands(std::vector<files::TomlTable> tables,
                                          std::mt19937_64& random);

/// The stretches one after the other; after them the last one's final set-point is held.
class CommandProgram {
 public:
  explicit CommandProgram(std::vector<CommandStretch> stretches);

  /// The command at this time, which must not be before that of the last call.
  Command<double> at(double time_s);
  double duration_s() const { return duration_s_; }

 private:
  std::vector<CommandStretch> stretches_;
  std::size_t now_ = 0;
  double began_s_ = 0;
  double duration_s_ = 0;
};

}  // namespace smaservo::bench
