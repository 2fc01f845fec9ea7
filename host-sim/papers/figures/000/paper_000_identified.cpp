// Figures 13 to 20: what was identified from the simulated wire's runs.

#include <fmt/format.h>
#include <functional>
#include <utility>

#include "host-sim/papers/figures/000/paper_000_drawing.hpp"
#include "model/units.hpp"

namespace smaservo::figures::paper_000 {
namespace {

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
      figure.panels.push_back(half_panel(
          fmt::format("{}, {}", of_strain ? "strain" : "specific resistance", names[k]), "",
          temperature_axis, stress_axis,
          block("run", {T[k], sigma[k], of_strain ? eps[k] : rho[k]}),
          settings + fmt::format("set cblabel '{}'\n", of_strain ? strain_axis : resistivity_axis),
          {"$run using 1:2:3 with points pt 5 ps 0.45 lc palette notitle"}));
    }
  }
  return figure;
}

PaperFigure figure_14() {
  const identify::FittedRun& run = fitted_without_stress().runs.front();
  // Both heat flows contain the specific heat. The row with the wire's earlier temperature is not
  // drawn.
  const std::string data =
      block("run", {degC(run.temperature_K), run.strain_measured, run.strain_model});
  const std::size_t hottest = run.temperature_K.size() / 2;
  return {
      14,
      "Transformation rates fitted to a calorimetry",
      fmt::format("Simulated wire without stress. The first stage of the fit leaves {:.1f} % of "
                  "the greatest heat flow; it cannot follow the grains of the simulated wire.",
                  100 * run.power.rms),
      {full_panel("heat flow with specific heat", "", temperature_axis, "heat flow in W/kg", data,
                  "set xrange [20:100]\n",
                  {line("run", "1:2 every ::2::" + std::to_string(hottest), heating_colour,
                        "simulated wire, heating"),
                   line("run", "1:2 " + cooling_rows(hottest + 1), cooling_colour, "cooling"),
                   line("run", "1:3 every ::2::" + std::to_string(hottest), model_colour, "model",
                        "lw 1.4"),
                   line("run", "1:3 " + cooling_rows(hottest + 1), model_colour, "", "lw 1.4")})}};
}

/// A pure phase over temperature, as gnuplot's function.
std::string pure_strain(const Phase<double>& phase, double stress_Pa) {
  return fmt::format("{:.6g}", 100 * (phase.strain + stress_Pa / phase.modulus_Pa));
}
std::string pure_resistivity(const Phase<double>& phase, double reference_K, double stress_Pa) {
  const double at_0_degC = phase.resistivity_ohm_m + stress_Pa * phase.resistivity_ohm_m_Pa -
                           (reference_K - zero_degC_K) * phase.resistivity_ohm_m_K;
  return fmt::format("{:.8g} + {:.6g}*x", 1e6 * at_0_degC, 1e6 * phase.resistivity_ohm_m_K);
}

PaperFigure figure_15() {
  const Level& level = fitted_levels()[1];
  const double stress_Pa = 1e6 * level.stress_MPa;
  const Material<double>& m = level.wire.material;
  const std::string data = bath_block("wire", simulated_bath_run(level.stress_MPa)) +
                           bath_block("model", model_bath_run(level.wire, level.stress_MPa));
  const std::pair<const Phase<double>*, std::pair<const char*, const char*>> phases[] = {
      {&m.martensite, {martensite_colour, "martensite"}},
      {&m.austenite, {austenite_colour, "austenite"}},
      {&m.r_phase, {"'#8a6d00'", "R-phase"}}};
  PaperFigure figure{
      15,
      fmt::format("Fit to one level of stress, {:.0f} MPa", level.stress_MPa),
      "Simulated wire (green) and the model fitted to this level alone (black). Dashed: "
      "what each phase would have by itself.",
      {}};
  for (const bool of_strain : {true, false}) {
    const char* columns = of_strain ? "1:2" : "1:3";
    std::vector<std::string> curves{line("wire", columns, r_phase_colour, "simulated wire", "lw 4"),
                                    line("model", columns, model_colour, "model", "lw 1.4")};
    for (const auto& [phase, look] : phases) {
      curves.push_back(fmt::format("{} with lines dt 2 lc rgb {} title '{}'",
                                   of_strain ? pure_strain(*phase, stress_Pa)
                                             : pure_resistivity(*phase, m.reference_K, stress_Pa),
                                   look.first, look.second));
    }
    figure.panels.push_back(half_panel(of_strain ? "strain" : "specific resistance", "",
                                       temperature_axis, of_strain ? strain_axis : resistivity_axis,
                                       data, "set xrange [20:150]\n", curves, 400));
  }
  return figure;
}

/// One value that depends on stress: what each level has found, and what all levels together say.
struct OverStress {
  const char* name;
  const char* colour;
  const char* look;  ///< of the line
  double max_MPa;    ///< up to which single levels determine it
  std::function<double(const Wire<double>&, double stress_Pa)> of;
};

report::Plot over_stress(const char* title, const char* label,
                         const std::vector<OverStress>& values, std::size_t first_level) {
  const std::vector<Level>& levels = fitted_levels();
  std::string data;
  std::vector<std::string> curves;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const OverStress& value = values[i];
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
    data += block(fmt::format("points{}", i), {at, found});
    data += block(fmt::format("line{}", i), {along, all});
    curves.push_back(fmt::format("$points{} using 1:2 with points pt {} ps 0.7 lc rgb {} notitle",
                                 i, value.look[0] == 'd' ? 6 : 7, value.colour));
    curves.push_back(line(fmt::format("line{}", i), "1:2", value.colour, value.name, value.look));
  }
  return half_panel(title, "", stress_axis, label, data, "set xrange [0:410]\nset key samplen 2\n",
                    curves, 420);
}

enum class Process : unsigned char { m2a, a2m, a2r };

Isobar<double> isobar_of(const Wire<double>& wire, Process process, double stress_Pa) {
  const ThreePhaseParams<double>& k = wire.kinetics;
  return isobar(process == Process::m2a   ? k.m2a
                : process == Process::a2m ? first_surface(k.a2m_a2r)
                                          : second_surface(k.a2m_a2r),
                stress_Pa);
}

OverStress of_process(Process process, const char* name, const char* look,
                      const std::function<double(const Isobar<double>&)>& take) {
  const bool a2r = process == Process::a2r;
  return {name,
          a2r                       ? r_phase_colour
          : process == Process::m2a ? heating_colour
                                    : cooling_colour,
          look, a2r ? max_a2r_MPa : 400, [=](const Wire<double>& wire, double stress_Pa) {
            return take(isobar_of(wire, process, stress_Pa));
          }};
}

constexpr const char* solid = "lw 1.8";
constexpr const char* dashed = "dt 2 lw 1.8";

PaperFigure figure_16() {
  const auto start = [](const Isobar<double>& at) { return at.start_K - zero_degC_K; };
  const auto finish = [](const Isobar<double>& at) {
    return at.start_K + 1 / at.per_K - zero_degC_K;
  };
  report::Plot plot = over_stress("transition temperatures", temperature_axis,
                                  {of_process(Process::m2a, "M2A/R2A start", solid, start),
                                   of_process(Process::m2a, "M2A/R2A finish", dashed, finish),
                                   of_process(Process::a2m, "A2M/R2M start", solid, start),
                                   of_process(Process::a2m, "A2M/R2M finish", dashed, finish),
                                   of_process(Process::a2r, "A2R start", solid, start),
                                   of_process(Process::a2r, "A2R finish", dashed, finish)},
                                  0);
  return {16,
          "Transition temperatures over stress",
          "Points: each level of stress by itself, that without stress from calorimetry. Lines: "
          "all levels together. A2R is known from levels up to 100 MPa.",
          {std::move(plot)}};
}

PaperFigure figure_17() {
  const auto curvature = [](const Isobar<double>& at) { return at.shape.curvature; };
  const auto turning = [](const Isobar<double>& at) { return at.shape.turning; };
  const auto both = [&](const auto& take) {
    return std::vector<OverStress>{of_process(Process::m2a, "M2A/R2A", solid, take),
                                   of_process(Process::a2m, "A2M/R2M", solid, take),
                                   of_process(Process::a2r, "A2R", solid, take)};
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
        {look.second, look.first, solid, max_MPa, [=](const Wire<double>& wire, double stress_Pa) {
           const Phase<double>& p = wire.material.*phase;
           return 100 * (p.strain + stress_Pa / p.modulus_Pa);
         }});
    resistivities.push_back(
        {look.second, look.first, solid, max_MPa, [=](const Wire<double>& wire, double stress_Pa) {
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
  std::string data;
  std::vector<std::string> curves[2];
  for (int stress_MPa = 50; stress_MPa <= 400; stress_MPa += 50) {
    const BathRun run = simulated_bath_run(stress_MPa);
    const std::string wire = fmt::format("wire{}", stress_MPa);
    const std::string model = fmt::format("model{}", stress_MPa);
    data += bath_block(wire, run) + bath_block(model, model_bath_run(fitted_model(), stress_MPa));
    const bool first = stress_MPa == 50;
    for (const int k : {0, 1}) {
      const std::string columns = fmt::format("1:{} ", k + 2);
      curves[k].push_back(line(wire, columns + heating_rows(run.hottest()), heating_colour,
                               first ? "simulated wire, heating" : "", "lw 2.6"));
      curves[k].push_back(line(wire, columns + cooling_rows(run.hottest()), cooling_colour,
                               first ? "cooling" : "", "lw 2.6"));
      curves[k].push_back(line(model, columns, model_colour, first ? "model" : "", "lw 0.9"));
    }
  }
  return {19,
          "Simulated wire and model",
          "50 to 400 MPa in steps of 50 MPa, from left to right. The model was fitted to six of "
          "the fifteen levels; 150, 250 and 350 MPa are not among them.",
          {full_panel("strain", "", temperature_axis, strain_axis, data, "set xrange [20:150]\n",
                      curves[0]),
           full_panel("specific resistance", "", temperature_axis, resistivity_axis, data,
                      "set xrange [20:150]\n", curves[1])}};
}

PaperFigure figure_20() {
  const double levels[] = {10, 50, 100, 150, 200, 250, 300, 400};
  const double raised = 2;  // per cent of strain from level to level
  std::string data;
  std::string labels;
  std::vector<std::string> left;
  std::vector<std::string> right;
  std::string gaps;
  for (std::size_t i = 0; i < std::size(levels); ++i) {
    const BathRun run = simulated_bath_run(levels[i]);
    const BathRun model = model_bath_run(fitted_model(), levels[i]);
    data +=
        bath_block(fmt::format("wire{}", i), run) + bath_block(fmt::format("model{}", i), model);
    const double up = raised * static_cast<double>(i);
    const std::string columns = fmt::format("4:($2+{})", up);
    left.push_back(line(fmt::format("wire{}", i), columns + " " + heating_rows(run.hottest()),
                        heating_colour, i == 0 ? "heating" : ""));
    left.push_back(line(fmt::format("wire{}", i), columns + " " + cooling_rows(run.hottest()),
                        cooling_colour, i == 0 ? "cooling" : ""));
    right.push_back(fmt::format(
        "$model{} using {}:(int($5)*65536+int($6)*256+int($7)) with lines lc rgb variable lw 2.5 "
        "notitle",
        i, columns));
    labels += fmt::format("set label '{:.0f} MPa' at graph 1.01, first {} font ',11'\n", levels[i],
                          100 * run.strain.front() + up);
    gaps += fmt::format("{}{:.0f}", i == 0 ? "" : ", ", 100 * self_sensing(model).gap);
  }
  const std::string settings =
      labels +
      "set rmargin 9\nset tmargin at screen 0.93\nset yrange [0:20]\nset ytics format ''\n"
      "set ytics 2\n";
  const char* label = "strain, one division is 2 %";
  return {
      20,
      "Strain over resistance",
      fmt::format("Each level stands 2 % above the last. Colour of the model: martensite blue, "
                  "R-phase green, austenite red. Gap of the model from heating to cooling in "
                  "% of the resistance's span: {}.",
                  gaps),
      {half_panel("simulated wire", "", "resistance of 100 mm in Ω", label, data, settings, left,
                  620),
       half_panel("model", "", "resistance of 100 mm in Ω", label, data, settings, right, 620)}};
}

}  // namespace

std::vector<PaperFigure> identified_figures() {
  return {figure_13(), figure_14(), figure_15(), figure_16(),
          figure_17(), figure_18(), figure_19(), figure_20()};
}

}  // namespace smaservo::figures::paper_000
