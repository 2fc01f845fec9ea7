#include "firmware/daemon/loop/prepared_device.hpp"

#include <algorithm>
#include <utility>

#include "firmware/device/adopt.hpp"
#include "firmware/device/device.hpp"
#include "firmware/parameters/parameters.hpp"

namespace smaservo::daemon {

struct ParameterSet {
  Prepared<double> prepared;
  std::uint32_t number;
  bool refused = false;
};

namespace {

bool needs_no_current(const Settings<double>& a, const Settings<double>& b) {
  return std::ranges::any_of(parameter_rows<double>, [&](const ParameterRow<double>& row) {
    return row.change == Change::without_current && row.get(a) != row.get(b);
  });
}

}  // namespace

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

bool is_refused(const ParameterSet& set) {
  return set.refused;
}

PreparedDevice::PreparedDevice(ParameterSetPtr set)
    : state_(std::make_unique<State>()), set_(std::move(set)) {}
PreparedDevice::~PreparedDevice() = default;

Output<double> PreparedDevice::step(const Inputs<double>& in, const Command<double>& command,
                                    double dt_s) {
  return Device<double>::step(set_->prepared, state_->device, in, command, dt_s);
}

ParameterSet* PreparedDevice::adopt(ParameterSet* set, bool heated) {
  if (heated && needs_no_current(set_->prepared.settings, set->prepared.settings)) {
    set->refused = true;
    return set;
  }
  smaservo::adopt(set_->prepared, set->prepared, state_->device);
  ParameterSet* const before = set_.release();
  set_.reset(set);
  return before;
}

}  // namespace smaservo::daemon
