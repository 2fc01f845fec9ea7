// Needs the headers of the model alone.

#include <smaservo/model/units.hpp>
#include <smaservo/model/wire/plant.hpp>
#include <smaservo/model/wire/three_phase/three_phase.hpp>

static_assert(smaservo::Kinetics<smaservo::ThreePhase<float>>);

int main() {
  constexpr smaservo::Unit degC{"degC", 1, smaservo::zero_degC_K};
  return degC.to_si(25) > smaservo::zero_degC_K ? 0 : 1;
}
