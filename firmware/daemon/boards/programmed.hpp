#pragma once
// Commands of a scenario file as a board's command source: for a first try without a bus, and for
// tests.

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
