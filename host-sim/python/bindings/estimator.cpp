// smaservo.Estimator

#include "observer/estimator.hpp"

#include "firmware/text/device_names.hpp"
#include "host-sim/python/bindings/wire.hpp"
#include "host-sim/replay/measurement_params.hpp"

namespace smaservo::python {
namespace {

Estimator<double> make_estimator(const files::WireDescription& wire, double ambient_K,
                                 const py::object& settings) {
  require_above_0("ambient_K", ambient_K, "greater than 0 and finite");
  const replay::RunSettings run = replay::parse_run_settings(overrides_of(settings));
  return {wire.wire, replay::measurement_params(wire.wire, run),
          replay::with_settings(kalman_tuning(wire.wire.accuracy), run), ambient_K};
}

constexpr const char* estimator_doc =
    R"(The observer: readings of current, voltage and load in, strain out.

It is what `host-sim replay` runs, to the last bit. ambient_K is a first guess of the air, which may
be 20 K off. settings are those of `--set`, with the keys observer.* and measurement.*. A copy
(copy.copy(), pickle) is a saved state.

>>> import smaservo
>>> estimator = smaservo.Estimator(smaservo.Wire.load("smartflex-76um"))
>>> now = estimator.update(current_A=0.01, voltage_V=0.24, load_N=0.68, dt_s=1e-3)
>>> now.health
'searching'
)";

constexpr const char* estimate_doc = R"(What an observer says of a wire.

strain is the elongation of the whole wire, strain_sd the standard deviation of its error.
temperature_K is the temperature of the wire's middle, martensite and r_phase are means over the whole wire, austenite is the rest. resistance_model_ohm is
the resistance that the model expects. health is "good", "searching" (several hypotheses about the
phases are still possible) or "doubtful" (the resistance contradicts the model). Without a reading,
all numbers are NaN.
)";

}  // namespace

void add_estimator(py::module_& module) {
  using E = Estimate<double>;
  py::class_<E> estimate(module, "Estimate", estimate_doc);
  estimate.attr("__module__") = "smaservo";
  estimate.def_readonly("strain", &E::strain);
  estimate.def_readonly("strain_sd", &E::strain_sd);
  estimate.def_readonly("temperature_K", &E::temperature_K);
  estimate.def_readonly("martensite", &E::martensite);
  estimate.def_readonly("r_phase", &E::r_phase);
  estimate.def_readonly("resistance_model_ohm", &E::resistance_model_ohm);
  estimate.def_property_readonly(
      "health", [](const E& e) { return std::string(text::health_name(e.health)); });
  estimate.def("__repr__", [](const E& e) {
    return fmt::format(
        "<smaservo.Estimate strain={:.5g} strain_sd={:.2g} temperature_K={:.5g} martensite={:.3g} "
        "r_phase={:.3g} health={}>",
        e.strain, e.strain_sd, e.temperature_K, e.martensite, e.r_phase,
        text::health_name(e.health));
  });
  estimate.def(py::pickle(
      [](const E& e) {
        return py::make_tuple(e.strain, e.strain_sd, e.temperature_K, e.martensite, e.r_phase,
                              e.resistance_model_ohm, static_cast<int>(e.health));
      },
      [](const py::tuple& t) {
        const auto at = [&](std::size_t i) { return t[i].cast<double>(); };
        const int health = t[6].cast<int>();
        if (health < 0 || health > static_cast<int>(Health::doubtful)) {
          throw py::value_error("the pickled estimate has no such health");
        }
        return E{at(0), at(1), at(2), at(3), at(4), at(5), static_cast<Health>(health)};
      }));

  using T = Estimator<double>;
  py::class_<T> type(module, "Estimator", estimator_doc);
  type.attr("__module__") = "smaservo";
  type.def(py::init(&make_estimator), py::arg("wire"), py::arg("ambient_K") = room_K,
           py::arg("settings") = py::none());
  type.def(
      "update",
      [](T& self, double current_A, double voltage_V, double load_N, double dt_s) {
        if (self.started() && !(0 < dt_s)) {
          refuse("dt_s", dt_s, "greater than 0");
        }
        return self.update({current_A, voltage_V, load_N}, dt_s);
      },
      py::arg("current_A"), py::arg("voltage_V"), py::arg("load_N"), py::arg("dt_s"),
      R"(The estimate after a reading that was taken dt_s after the last one.

The dt_s of the first reading is not used. After more than 60 s the estimator starts anew. A reading
that is NaN has failed: it is not used, the others are. Before the first reading with a load, the
estimate is NaN. Raises ValueError for a dt_s that is not greater than 0; nothing changes then.
)");
  type.def("restart", &T::restart, "Forgets all readings.");
  type.def_property_readonly("started", &T::started,
                             "Whether there has been a reading with a load.");
  add_state<T>(type);
}

}  // namespace smaservo::python
