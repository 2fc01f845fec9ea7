// A wire of one temperature: current and load in, strain and resistance out.

#include <cmath>

#include "host-sim/fmu/unit/check.hpp"
#include "host-sim/fmu/unit/component.hpp"
#include "host-sim/fmu/unit/wire_variables.hpp"
#include "model/wire/wire_plant.hpp"

namespace smaservo::fmu::unit {
namespace {

class WireComponent : public Component {
 public:
  /// With values that are allowed.
  WireComponent(std::vector<Variable> variables, std::vector<double> start, Surfaces surfaces)
      : Component(std::move(variables), std::move(start)),
        surfaces_(surfaces),
        plant_(plant_now()) {}

  /// "" or what is wrong with the values.
  static std::string wrong(const std::vector<Variable>& variables,
                           const std::vector<double>& values, Surfaces surfaces) {
    const std::string problem = wrong_value(variables, values);
    std::size_t next = wire_parameters_at;
    return problem.empty() ? wrong_wire(read_wire(values, next, surfaces)) : problem;
  }

  std::string begin() override {
    std::string problem = wrong(variables(), values, surfaces_);
    if (!problem.empty()) {
      return problem;
    }
    const WirePlant<double> plant = plant_now();
    if (!is_made(plant.output())) {
      return "the wire has no state of rest under this load_N at this ambient_K";
    }
    plant_ = plant;
    show();
    return "";
  }

  std::string advance(double /*to_s*/, double step_s) override {
    WirePlant<double> plant = plant_;
    const double parts = std::ceil(step_s / WirePlant<double>::longest_update_s);
    for (double i = 0; i < parts; ++i) {
      if (!is_made(plant.update(input(), step_s / parts))) {
        return "the step has no finite result: an input is far beyond what a wire can bear";
      }
    }
    plant_ = plant;
    show();
    return "";
  }

  std::span<std::byte> memory() override { return std::as_writable_bytes(std::span(&plant_, 1)); }

 private:
  WirePlant<double> plant_now() const {
    std::size_t next = wire_parameters_at;
    return WirePlant<double>(read_wire(values, next, surfaces_), input().load_N, input().ambient_K);
  }
  WireInput<double> input() const {
    const double* in = &values[wire_inputs_at];
    return {.current_A = in[0], .load_N = in[1], .ambient_K = in[2], .draught = in[3]};
  }
  void show() {
    const WireOutput<double> now = plant_.output();
    const double current_A = input().current_A;
    double* out = &values[wire_outputs_at];
    // The first parameter is the wire's length.
    show_wire(now, values[wire_parameters_at], out);
    out[wire_state_count] = current_A * now.resistance_ohm;
    out[wire_state_count + 1] = current_A * current_A * now.resistance_ohm;
  }

  Surfaces surfaces_;
  WirePlant<double> plant_;
};

}  // namespace

std::unique_ptr<Component> make_component(Constants& constants) {
  const Surfaces surfaces{constants.take("separate_r2a") != 0, constants.take("separate_r2m") != 0};
  std::vector<Variable> variables = wire_variables(surfaces);
  std::vector<double> start = start_values(variables, constants);
  const std::string problem = WireComponent::wrong(variables, start, surfaces);
  if (!problem.empty()) {
    throw ConstantsError(problem);
  }
  return std::make_unique<WireComponent>(std::move(variables), std::move(start), surfaces);
}

const char* component_kind() {
  return "wire";
}

}  // namespace smaservo::fmu::unit
