#include "hal/sim/lumped_wire.hpp"

#include "model/wire/plant.hpp"

namespace smaservo::hal {
namespace {

class LumpedWire : public SimulatedWire {
 public:
  using Model = Plant<ThreePhase<double>>;

  explicit LumpedWire(const Wire<double>& wire)
      : params_(plant_params(wire)),
        still_(params_.body),
        state_(Model::rest(params_, {room_K, 0})) {
    // A wire reverses after any change of temperature; only an observer needs a threshold, because
    // of noise.
    params_.kinetics.smallest_reversal_K = 0;
    look(ambient_K_);
  }

  void rest(double temperature_K, double stress_Pa) final {
    state_ = Model::rest(params_, {temperature_K, stress_Pa});
    look(temperature_K);
  }
  void soak(double temperature_K, double stress_Pa) final {
    ThreePhase<double>::advance(params_.kinetics, state_.kinetics, {temperature_K, stress_Pa});
    look(temperature_K);
  }
  void advance(double current_A, const Surroundings& around, double dt_s) final {
    params_.body.loss_W_K = around.draught * still_.loss_W_K;
    params_.body.loss_W_K2 = around.draught * still_.loss_W_K2;
    if (around.ambient_K != ambient_K_) {
      look(around.ambient_K);
    }
    const double power_W = current_A * current_A * ohm_;
    Model::advance(params_, state_, {power_W, around.stress_Pa, around.ambient_K}, dt_s);
    look(around.ambient_K);
  }
  double strain_after(double current_A, const Surroundings& around, double dt_s) const final {
    LumpedWire trial = *this;
    trial.advance(current_A, around, dt_s);
    return trial.strain();
  }

  double strain() const final { return Model::strain(params_, state_); }
  double resistance_ohm() const final { return ohm_; }
  double hottest_K() const final { return Model::temperature_K(state_); }
  double average_K() const final {
    return params_.ends.average_K(Model::temperature_K(state_), ambient_K_);
  }
  Phases<double> phases() const final { return params_.ends.average(Model::phases(state_)); }

 private:
  void look(double ambient_K) {
    ambient_K_ = ambient_K;
    ohm_ = Model::resistance_ohm(params_, state_, ambient_K);
  }

  Model::Params params_;
  ThermalBody<double> still_;
  Model::State state_;
  double ambient_K_ = room_K;
  double ohm_ = 0;
};

}  // namespace

std::unique_ptr<SimulatedWire> make_lumped_wire(const Wire<double>& wire) {
  return std::make_unique<LumpedWire>(wire);
}

}  // namespace smaservo::hal
