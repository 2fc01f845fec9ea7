#pragma once
// Commands of a scenario file as a board's partner: for a first try without a bus, and for tests.

#include <utility>
#include <vector>

#include "firmware/bench/command_program.hpp"
#include "firmware/daemon/loop/partner.hpp"

namespace smaservo {

class Programmed : public Partner {
 public:
  explicit Programmed(std::vector<CommandStretch> program) : program_(std::move(program)) {}
  Heard<double> listen(double time_s) override { return {program_.at(time_s), {}}; }

 private:
  CommandProgram program_;
};

}  // namespace smaservo
