#include "firmware/daemon/loop/axis.hpp"

#include <utility>

#include "firmware/device/adopt.hpp"
#include "firmware/device/device.hpp"

namespace smaservo {

struct ParameterSet {
  Prepared<double> prepared;
  std::uint32_t number;
};

struct Axis::Parts {
  Device<double>::State state = Device<double>::start();
  Output<double> output{};
};

void DeleteParameterSet::operator()(ParameterSet* set) const {
  delete set;
}

ParameterSetPtr make_parameter_set(const Settings<double>& settings, std::uint32_t number) {
  return ParameterSetPtr(new ParameterSet{prepare(settings), number});
}

std::uint32_t number_of(const ParameterSet& set) {
  return set.number;
}

Axis::Axis(ParameterSetPtr set) : parts_(std::make_unique<Parts>()), set_(std::move(set)) {}
Axis::~Axis() = default;

const Output<double>& Axis::step(const Inputs<double>& in, const Command<double>& command,
                                 double dt_s) {
  parts_->output = Device<double>::step(set_->prepared, parts_->state, in, command, dt_s);
  return parts_->output;
}

ParameterSet* Axis::adopt(ParameterSet* set) {
  smaservo::adopt(set_->prepared, set->prepared, parts_->state);
  ParameterSet* const before = set_.release();
  set_.reset(set);
  return before;
}

}  // namespace smaservo
