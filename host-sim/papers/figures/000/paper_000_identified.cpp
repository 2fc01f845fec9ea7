// Figures 13 to 20: the results identified from the runs of the simulated wire.

#include <fmt/format.h>
#include <functional>
#include <utility>

#include "host-sim/papers/figures/000/paper_000_drawing.hpp"
#include "host-sim/report/gnuplot.hpp"
#include "model/units.hpp"

namespace smaservo::figures::paper_000 {
namespace {

/// Columns of equal length as gnuplot's data block `$name`.
std::string block(std::string_view name, const std::vector<Column>& columns) {
  std::string text = fmt::format("${} << EOD\n", name);
  for (std::size_t row = 0; row < columns.front().size(); ++row) {
    Column values;
    for (const Column& column : columns) {
      values.push_back(column[row]);
    }
    text += report::plotted_row(values);
  }
  return text + "EOD\n";
}

PaperFigure figure_13() {
  Column T[2];
  Column sigma[2];
  Column eps[2];
  Column rho[2];
  for (const double stress_MPa : stresses_MPa) {
    const BathRun run = simulated_bath_run(stress_MPa);
    for (std::size_t i = 0; i < run.rows(); ++i) {
      const std::size_t cools = i > run.hottest() ? 1 : 0;
      T[cools].push_back(run.temperature_K[i] - zero_degC_K);
      sigma[cools].push_back(stress_MPa);
      eps[cools].push_back(100 * run.strain[i]);
      rho[cools].push_back(1e6 * run.resistivity_ohm_m[i]);
    }
  }
  const std::string settings =
      "set palette defined (0 '#440154', 0.25 '#3b528b', 0.5 '#21918c', 0.75 '#5ec962', 1 "
      "'#fde725')\nset xrange [20:150]\nset yrange [0:410]\n";
  PaperFigure figure{
      13,
      "The experiments in temperature and stress",
      "Fifteen runs of the simulated wire; colour is what is measured. The edge between "
      "long and short climbs with stress, and with R-phase below 100 MPa the resistance "
      "rises before the wire gets long.",
      {}};
  const char* const names[] = {"heating", "cooling"};
  for (const bool of_strain : {true, false}) {
    for (std::size_t k = 0; k < 2; ++k) {
      // Each point has its own colour, so gnuplot draws the picture.
      report::Panel panel =
          half_panel(fmt::format("{}, {}", of_strain ? "strain" : "specific resistance", names[k]),
                     {}, {}, {});
      panel.svg = report::draw(
          {500, panel.height, temperature_axis, stress_axis},
          block("run", {T[k], sigma[k], of_strain ? eps[k] : rho[k]}),
          settings + fmt::format("set cblabel '{}'\n", of_strain ? strain_axis : resistivity_axis),
          {"$run using 1:2:3 with points pt 5 ps 0.45 lc palette notitle"});
      figure.panels.push_back(std::move(panel));
    }
  }
  return figure;
}

PaperFigure figure_14() {
  const identify::FittedRun& run = fitted_without_stress().runs.front();
  // Both heat flows contain the specific heat. The first two rows are not drawn: the state at 213 K
  // before the run, and the step from it to the run's first temperature.
  const std::size_t hottest = run.temperature_K.size() / 2;
  const auto heating = [&](const Column& all) {
    const Column part = heating_part(all, hottest);
    return Column(part.begin() + 2, part.end());
  };
  const auto cooling = [&](const Column& all) { return cooling_part(all, hottest + 1); };
  const Column T = degC(run.temperature_K);
  return {
      14,
      "Transformation rates fitted to a calorimetry",
      fmt::format("Simulated wire without stress. The first stage of the fit leaves {:.1f} % of "
                  "the greatest heat flow; it cannot follow the grains of the simulated wire.",
                  100 * run.power.rms),
      {full_panel("heat flow with specific heat", axis(temperature_axis, 20, 100),
                  axis("heat flow in W/kg"),
                  {line(heating(T), heating(run.strain_measured), heating_colour,
                        "simulated wire, heating"),
                   line(cooling(T), cooling(run.strain_measured), cooling_colour, "cooling"),
                   line(heating(T), heating(run.strain_model), "ink", "model", 1.4),
                   line(cooling(T), cooling(run.strain_model), "ink", "model", 1.4)})}};
}

/// A pure phase from 20 to 150 °C.
report::Series pure(const char* name, const char* colour, double at_0_degC, double per_K) {
  const Column ends{20, 150};
  return dashed(line(ends, {at_0_degC + 20 * per_K, at_0_degC + 150 * per_K}, colour, name, 1));
}
report::Series pure_strain(const char* name, const char* colour, const Phase<double>& phase,
                           double stress_Pa) {
  return pure(name, colour, 100 * (phase.strain + stress_Pa / phase.modulus_Pa), 0);
}
report::Series pure_resistivity(const char* name, const char* colour, const Phase<double>& phase,
                                double reference_K, double stress_Pa) {
  const double at_0_degC = phase.resistivity_ohm_m + stress_Pa * phase.resistivity_ohm_m_Pa -
                           (reference_K - zero_degC_K) * phase.resistivity_ohm_m_K;
  return pure(name, colour, 1e6 * at_0_degC, 1e6 * phase.resistivity_ohm_m_K);
}

PaperFigure figure_15() {
  const Level& level = fitted_levels()[1];
  const double stress_Pa = 1e6 * level.stress_MPa;
  const Material<double>& m = level.wire.material;
  const BathRun wire = simulated_bath_run(level.stress_MPa);
  const BathRun model = model_bath_run(level.wire, level.stress_MPa);
  const std::pair<const Phase<double>*, std::pair<const char*, const char*>> phases[] = {
      {&m.martensite, {martensite_colour, "martensite"}},
      {&m.austenite, {austenite_colour, "austenite"}},
      {&m.r_phase, {"#8a6d00", "R-phase"}}};
  PaperFigure figure{
      15,
      fmt::format("Fit to one level of stress, {:.0f} MPa", level.stress_MPa),
      "Simulated wire (green) and the model fitted to this level alone (black). Dashed: "
      "what each phase would have by itself.",
      {}};
  for (const bool of_strain : {true, false}) {
    const auto curve = [&](const BathRun& run, const char* colour, const char* name, double width) {
      return line(degC(run.temperature_K),
                  of_strain ? times(100, run.strain) : times(1e6, run.resistivity_ohm_m), colour,
                  name, width);
    };
    std::vector<report::Series> curves{curve(wire, r_phase_colour, "simulated wire", 4),
                                       curve(model, "ink", "model", 1.4)};
    for (const auto& [phase, look] : phases) {
      const auto& [colour, name] = look;
      curves.push_back(of_strain
                           ? pure_strain(name, colour, *phase, stress_Pa)
                           : pure_resistivity(name, colour, *phase, m.reference_K, stress_Pa));
    }
    figure.panels.push_back(
        half_panel(of_strain ? "strain" : "specific resistance", axis(temperature_axis, 20, 150),
                   axis(of_strain ? strain_axis : resistivity_axis), std::move(curves), 400));
  }
  return figure;
}

/// A value that depends on stress: the results of the single levels, and that of all levels
/// together.
struct OverStress {
  const char* name;
  const char* colour;
  bool dashed;
  double max_MPa;  ///< greatest stress at which single levels determine it
  std::function<double(const Wire<double>&, double stress_Pa)> of;
};

report::Panel over_stress(const char* title, const char* label,
                          const std::vector<OverStress>& values, std::size_t first_level) {
  const std::vector<Level>& levels = fitted_levels();
  std::vector<report::Series> curves;
  for (const OverStress& value : values) {
    Column at;
    Column found;
    for (std::size_t k = first_level; k < levels.size(); ++k) {
      if (levels[k].stress_MPa <= value.max_MPa) {
        at.push_back(levels[k].stress_MPa);
        found.push_back(value.of(levels[k].wire, 1e6 * levels[k].stress_MPa));
      }
    }
    Column along;
    Column all;
    for (int s = 0; s <= 400; s += 10) {
      along.push_back(s);
      all.push_back(value.of(fitted_model(), 1e6 * s));
    }
    const report::Series curve = line(along, all, value.colour, value.name);
    curves.push_back(value.dashed ? dashed(curve) : curve);
    curves.push_back(line(at, found, value.colour, value.name));
    curves.back().kind = report::Kind::points;
  }
  return half_panel(title, axis(stress_axis, 0, 410), axis(label), std::move(curves), 420);
}

enum class Process : unsigned char { m2a, a2m, a2r };

Isobar<double> isobar_of(const Wire<double>& wire, Process process, double stress_Pa) {
  const ThreePhaseParams<double>& k = wire.kinetics;
  return isobar(process == Process::m2a   ? k.m2a
                : process == Process::a2m ? first_surface(k.a2m_a2r)
                                          : second_surface(k.a2m_a2r),
                stress_Pa);
}

OverStress of_process(Process process, const char* name, bool dashed,
                      const std::function<double(const Isobar<double>&)>& take) {
  const bool a2r = process == Process::a2r;
  return {name,
          a2r                       ? r_phase_colour
          : process == Process::m2a ? heating_colour
                                    : cooling_colour,
          dashed, a2r ? max_a2r_MPa : 400, [=](const Wire<double>& wire, double stress_Pa) {
            return take(isobar_of(wire, process, stress_Pa));
          }};
}

PaperFigure figure_16() {
  const auto start = [](const Isobar<double>& at) { return at.start_K - zero_degC_K; };
  const auto finish = [](const Isobar<double>& at) {
    return at.start_K + 1 / at.per_K - zero_degC_K;
  };
  report::Panel panel = over_stress("transition temperatures", temperature_axis,
                                    {of_process(Process::m2a, "M2A/R2A start", false, start),
                                     of_process(Process::m2a, "M2A/R2A finish", true, finish),
                                     of_process(Process::a2m, "A2M/R2M start", false, start),
                                     of_process(Process::a2m, "A2M/R2M finish", true, finish),
                                     of_process(Process::a2r, "A2R start", false, start),
                                     of_process(Process::a2r, "A2R finish", true, finish)},
                                    0);
  return {16,
          "Transition temperatures over stress",
          "Points: each level of stress by itself, that without stress from calorimetry. Lines: "
          "all levels together. A2R is known from levels up to 100 MPa.",
          {std::move(panel)}};
}

PaperFigure figure_17() {
  const auto curvature = [](const Isobar<double>& at) { return at.shape.curvature; };
  const auto turning = [](const Isobar<double>& at) { return at.shape.turning; };
  const auto both = [&](const auto& take) {
    return std::vector<OverStress>{of_process(Process::m2a, "M2A/R2A", false, take),
                                   of_process(Process::a2m, "A2M/R2M", false, take),
                                   of_process(Process::a2r, "A2R", false, take)};
  };
  return {
      17,
      "Shape over stress",
      "Points: each level by itself, which knows Γ only roughly: it trades against the plateaus "
      "of the strain. Lines: all together. The simulated wire's short tails want little of it.",
      {over_stress("curvature", "curvature Γ", both(curvature), 1),
       over_stress("asymmetry", "asymmetry z_T", both(turning), 1)}};
}

PaperFigure figure_18() {
  using Of = Phase<double> Material<double>::*;
  const std::pair<Of, std::pair<const char*, const char*>> phases[] = {
      {&Material<double>::martensite, {martensite_colour, "martensite"}},
      {&Material<double>::r_phase, {r_phase_colour, "R-phase"}},
      {&Material<double>::austenite, {austenite_colour, "austenite"}}};
  std::vector<OverStress> strains;
  std::vector<OverStress> resistivities;
  for (const auto& [which, look] : phases) {
    const Of phase = which;
    const double max_MPa = phase == &Material<double>::r_phase ? max_a2r_MPa : 400;
    strains.push_back(
        {look.second, look.first, false, max_MPa, [=](const Wire<double>& wire, double stress_Pa) {
           const Phase<double>& p = wire.material.*phase;
           return 100 * (p.strain + stress_Pa / p.modulus_Pa);
         }});
    resistivities.push_back(
        {look.second, look.first, false, max_MPa, [=](const Wire<double>& wire, double stress_Pa) {
           const Phase<double>& p = wire.material.*phase;
           return 1e6 * (p.resistivity_ohm_m + stress_Pa * p.resistivity_ohm_m_Pa);
         }});
  }
  return {
      18,
      "The pure phases over stress",
      "Points: each level by itself, of R-phase up to 100 MPa; lines: all together. The slope of "
      "the strain is 1/E. Austenite's resistance rises with stress, martensite's does not.",
      {over_stress("strain", strain_axis, strains, 1),
       over_stress("specific resistance at 20 °C", resistivity_axis, resistivities, 1)}};
}

PaperFigure figure_19() {
  std::vector<report::Series> curves[2];
  for (int stress_MPa = 50; stress_MPa <= 400; stress_MPa += 50) {
    const BathRun run = simulated_bath_run(stress_MPa);
    const BathRun model = model_bath_run(fitted_model(), stress_MPa);
    for (const bool of_strain : {true, false}) {
      const auto values = [&](const BathRun& of) {
        return of_strain ? times(100, of.strain) : times(1e6, of.resistivity_ohm_m);
      };
      std::vector<report::Series>& all = curves[of_strain ? 0 : 1];
      for (report::Series& series : cycle(degC(run.temperature_K), values(run), run.hottest(),
                                          "simulated wire, heating", "cooling", 2.6)) {
        all.push_back(std::move(series));
      }
      all.push_back(line(degC(model.temperature_K), values(model), "ink", "model", 0.9));
    }
  }
  return {19,
          "Simulated wire and model",
          "50 to 400 MPa in steps of 50 MPa, from left to right. The model was fitted to six of "
          "the fifteen levels; 150, 250 and 350 MPa are not among them.",
          {full_panel("strain", axis(temperature_axis, 20, 150), axis(strain_axis),
                      std::move(curves[0])),
           full_panel("specific resistance", axis(temperature_axis, 20, 150),
                      axis(resistivity_axis), std::move(curves[1]))}};
}

/// `run` as gnuplot's data block: resistance in Ω, strain in %, and red, green and blue (0 to 255)
/// from the fractions of austenite, R-phase and martensite.
std::string coloured_block(std::string_view name, const BathRun& run) {
  Column red;
  Column green;
  Column blue;
  for (const Phases<double>& z : run.phases) {
    red.push_back(255 * z.austenite());
    green.push_back(255 * z.r_phase);
    blue.push_back(255 * z.martensite);
  }
  return block(name, {resistances_ohm(run), times(100, run.strain), red, green, blue});
}

PaperFigure figure_20() {
  const double levels[] = {10, 50, 100, 150, 200, 250, 300, 400};
  const double raised = 2;  // offset of the strain in per cent from level to level
  std::string data;
  std::vector<std::string> coloured;
  std::string gaps;
  report::Panel left = half_panel("simulated wire", axis("resistance of 100 mm in Ω"),
                                  axis("strain, one division is 2 %", 0, 20), {}, 620);
  std::string labels;
  for (std::size_t i = 0; i < std::size(levels); ++i) {
    const BathRun run = simulated_bath_run(levels[i]);
    const BathRun model = model_bath_run(fitted_model(), levels[i]);
    const double up = raised * static_cast<double>(i);
    Column strain = times(100, run.strain);
    for (double& value : strain) {
      value += up;
    }
    const Column ohm = resistances_ohm(run);
    for (report::Series& series : cycle(ohm, strain, run.hottest())) {
      left.series.push_back(std::move(series));
    }
    const std::string name = fmt::format("{:.0f} MPa", levels[i]);
    left.notes.push_back({ohm.front(), strain.front() + 0.3, name});
    data += coloured_block(fmt::format("model{}", i), model);
    labels += fmt::format("set label '{}' at graph 1.01, first {} font ',11'\n", name,
                          100 * model.strain.front() + up);
    coloured.push_back(fmt::format(
        "$model{} using 1:($2+{}):(int($3)*65536+int($4)*256+int($5)) with lines lc rgb variable "
        "lw 2.5 notitle",
        i, up));
    gaps += fmt::format("{}{:.0f}", i == 0 ? "" : ", ", 100 * self_sensing(model).gap);
  }
  // Each point has its own colour, so gnuplot draws the picture.
  report::Panel right = half_panel("model", {}, {}, {}, left.height);
  right.svg = report::draw({500, left.height, left.x.label, left.y.label}, data,
                           labels +
                               "set rmargin 9\nset tmargin at screen 0.93\nset yrange [0:20]\n"
                               "set ytics format ''\nset ytics 2\n",
                           coloured);
  return {20,
          "Strain over resistance",
          fmt::format("Each level stands 2 % above the last. Colour of the model: martensite blue, "
                      "R-phase green, austenite red. Gap of the model from heating to cooling in "
                      "% of the resistance's span: {}.",
                      gaps),
          {std::move(left), std::move(right)}};
}

}  // namespace

std::vector<PaperFigure> identified_figures() {
  return {figure_13(), figure_14(), figure_15(), figure_16(),
          figure_17(), figure_18(), figure_19(), figure_20()};
}

}  // namespace smaservo::figures::paper_000
