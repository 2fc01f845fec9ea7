// What a step needs, whatever it runs on: prints how many operations the algorithm has, over the
// project's traces, and how wide the ranges of its numbers are. No loads, no branches, no calls: a
// processor's instructions in relation to this are its overhead.

#include <algorithm>
#include <bit>
#include <cstdio>
#include <map>
#include <string>

#include "firmware/parameters/parameter_check.hpp"
#include "observer/multiple_model.hpp"
#include "observer/open_loop.hpp"
#include "observer/substepping.hpp"
#include "tests/bench/convert_observer.hpp"
#include "tests/bench/counted.hpp"
#include "tests/bench/device_steps.hpp"
#include "tests/observer/shipped_traces.hpp"

namespace smaservo::benchmarks {
namespace {

using S = Counted;

/// Over many steps of a kind.
class Steps {
 public:
  template <class Step>
  void count(Step&& step) {
    const Operations before = S::operations;
    step();
    const Operations now = S::operations - before;
    ++steps_;
    sum_.additions += now.additions;
    sum_.multiplications += now.multiplications;
    sum_.divisions += now.divisions;
    sum_.roots += now.roots;
    sum_.comparisons += now.comparisons;
    sum_.functions += now.functions;
    worst_ = std::max(worst_, now.all());
  }
  void print(const char* name) const {
    const auto mean = [&](std::uint64_t sum) {
      return static_cast<double>(sum) / static_cast<double>(steps_);
    };
    std::printf("| %s | %.0f | %.0f | %.1f | %.1f | %.0f | %.2f | %.0f | %llu |\n", name,
                mean(sum_.additions), mean(sum_.multiplications), mean(sum_.divisions),
                mean(sum_.roots), mean(sum_.comparisons), mean(sum_.functions), mean(sum_.all()),
                static_cast<unsigned long long>(worst_));
  }

 private:
  Operations sum_;
  std::uint64_t steps_ = 0;
  std::uint64_t worst_ = 0;
};

class Ranges {
 public:
  void add(const std::string& name, const S& x) { ranges_[name].add(static_cast<double>(x)); }
  void print() const {
    std::puts("| number | least | greatest | in powers of two |\n|---|--:|--:|--:|");
    for (const auto& [name, range] : ranges_) {
      std::printf("| %s | %.2g | %.3g | %.0f to %.0f |\n", name.c_str(), range.min, range.max,
                  std::floor(std::log2(range.min)), std::ceil(std::log2(range.max)));
    }
  }

 private:
  std::map<std::string, Magnitudes> ranges_;
};

constexpr double ambient_K = room_K;

void note(Ranges& ranges, const KalmanObserver<S>::State& f) {
  using Filter = KalmanObserver<S>;
  const auto& k = f.kinetics;
  ranges.add("temperature, K", k.drive.temperature_K);
  ranges.add("stress, Pa", k.drive.stress_Pa);
  ranges.add("martensite", k.martensite);
  ranges.add("R-phase", k.r_phase);
  ranges.add("returning", k.returning);
  ranges.add("left of M2A", k.reverse.m2a);
  ranges.add("left of A2M", k.forward.a2m_a2r.first());
  ranges.add("left of A2R", k.forward.a2m_a2r.second());
  ranges.add("rate of martensite, 1/K", f.rates.martensite_1_K);
  ranges.add("rate of R-phase, 1/K", f.rates.r_phase_1_K);
  ranges.add("heat carried, J", f.heat_J);
  ranges.add("innovation, ohm", f.innovation_ohm);
  ranges.add("variance of the innovation, ohm2", f.innovation_variance);
  const char* const names[] = {"T", "M", "R", "ambient", "loss", "resistance"};
  for (int i = 0; i < Filter::size; ++i) {
    for (int j = 0; j <= i; ++j) {
      ranges.add(std::string("covariance ") + names[j] + ", " + names[i], f.covariance.at(i, j));
    }
  }
}

struct Table {
  Steps kinetics, plant, filter, sure, search, whole;
  Ranges ranges;

  void traces() {
    for (const ShippedTrace& trace : shipped_traces()) {
      const Wire<double> wire = load_unit(trace);
      const auto model = convert<S>(plant_params(wire));
      const KalmanTuning<S> tuning = convert<S>(kalman_tuning(wire.accuracy));
      const MeasurementParams<S> measurement = convert<S>(measurement_params(wire));
      const auto steps = load_trace(trace);
      const auto first = measure(measurement, convert<S>(steps.front().sample));
      using Model = Plant<ThreePhase<S>>;
      using Search = MultipleModelFilter<S>;
      using Filter = KalmanObserver<S>;
      Model::State lumped = Model::rest(model, {S(ambient_K), first.stress_Pa});
      ThreePhase<S>::State kinetic = lumped.kinetics;
      Filter::State single = Filter::start({model, tuning}, first, S(ambient_K));
      Search::State many = Search::start({model, tuning}, first, S(ambient_K));
      for (const TraceStep& step : steps) {
        const auto m = measure(measurement, convert<S>(step.sample));
        const S dt_s(std::clamp(step.dt_s, 1e-4, 5e-3));
        plant.count(
            [&] { Model::advance(model, lumped, {m.power_W, m.stress_Pa, S(ambient_K)}, dt_s); });
        const Drive<S> drive = lumped.kinetics.drive;
        kinetics.count([&] { ThreePhase<S>::advance(model.kinetics, kinetic, drive); });
        filter.count([&] {
          Filter::advance({model, tuning}, single, m, dt_s);
          Filter::estimate({model, tuning}, single);
        });
        (Search::alive(many) > 1 ? search : sure).count([&] {
          Search::advance({model, tuning}, many, m, dt_s);
          Search::estimate({model, tuning}, many);
        });
        note(ranges, Search::likeliest(many));
      }
    }
  }

  void device() {
    DeviceStep<S> step;
    for (std::size_t i = 0; i < step.period(); ++i) {
      whole.count(step);
    }
  }

  void print() const {
    std::puts("Operations that a step needs, mean over the traces, and all of the worst one:\n");
    std::puts(
        "| step | + - | x | / | root | < | exp, ceil | all | worst |\n"
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|");
    kinetics.print("model (kinetics)");
    plant.print("model with heat balance");
    filter.print("filter");
    sure.print("observer, sure");
    search.print("observer, searching");
    whole.print("measure, observe, protect, control");
    std::printf("\nResults of all of them: 2^%.0f to 2^%.0f.\n\n",
                std::floor(std::log2(S::results.min)), std::ceil(std::log2(S::results.max)));
    std::puts("Ranges of the numbers that are kept:\n");
    ranges.print();
  }
};

}  // namespace
}  // namespace smaservo::benchmarks

int main() {
  smaservo::benchmarks::Table table;
  table.traces();
  table.device();
  table.print();
}
