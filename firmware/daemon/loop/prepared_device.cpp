#include "firmware/daemon/loop/prepared_device.hpp"

#include <utility>

#include "firmware/device/adopt.hpp"
#include "firmware/device/device.hpp"

namespace smaservo::daemon {

struct ParameterSet {
  Prepared<double> prepared;
  std::uint32_t number;
};

struct PreparedDevice::State {
  Device<double>::State device = Device<double>::start();
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

PreparedDevice::PreparedDevice(ParameterSetPtr set)
    : state_(std::make_unique<State>()), set_(std::move(set)) {}
PreparedDevice::~PreparedDevice() = default;

Output<double> PreparedDevice::step(const Inputs<double>& in, const Command<double>& command,
                                    double dt_s) {
  return Device<double>::step(set_->prepared, state_->device, in, command, dt_s);
}

ParameterSet* PreparedDevice::adopt(ParameterSet* set) {
  smaservo::adopt(set_->prepared, set->prepared, state_->device);
  ParameterSet* const before = set_.release();
  set_.reset(set);
  return before;
}

}  // namespace smaservo::daemon
