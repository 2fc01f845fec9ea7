#pragma once
// The commands of a scenario file as a command source for a board: for a first test without a bus,
// and for automated tests.

#include <utility>
#include <vector>

#include "firmware/bench/scenario/command_program.hpp"
#include "firmware/daemon/loop/command_source.hpp"

namespace smaservo::daemon {

class Programmed : public CommandSource {
 public:
  explicit Programmed(std::vector<bench::CommandStretch> program) : program_(std::move(program)) {}
  Heard<double> listen(double time_s) override { return {program_.at(time_s), {}}; }

 private:
  bench::CommandProgram program_;
};

}  // namespace smaservo::daemon
