#pragma once
// An observer that is a program of the user's. README.md has its protocol.

#include <chrono>
#include <string>
#include <vector>

#include "host-sim/simulate/simulate.hpp"
#include "model/wire/wire.hpp"

namespace smaservo::evaluate {

/// The program's answer to one row.
struct ProgramAnswer {
  double strain;
  double strain_sd;  ///< NaN if the program gives none
};

/// Throws UserError if a path is not that of a program that may be run.
void check_observer_program(const std::string& program);

/// The names of programs in the table: the file's name, or the path as it was given if the file's
/// name is that of another program or of a built-in observer. Throws UserError if a program is
/// given twice.
std::vector<std::string> observer_program_names(const std::vector<std::string>& programs);

/// A program that for so long neither reads a row nor answers is ended.
inline constexpr std::chrono::milliseconds program_patience{60'000};

/// Starts the program, gives it the measured values of one run and ends it, and with it whatever it
/// has started in its process group. One answer for each row. `run` names the run in errors. Throws
/// UserError if the program cannot be started, fails, or does not keep the protocol, and if a
/// signal comes while an EndBySignal exists.
std::vector<ProgramAnswer> ask_observer_program(
    const std::string& program, const Wire<double>& wire,
    const std::vector<simulate::SimulatedRow>& rows, const std::string& run,
    std::chrono::milliseconds patience = program_patience);

}  // namespace smaservo::evaluate
