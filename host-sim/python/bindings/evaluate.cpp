// smaservo.evaluate()

#include "host-sim/evaluate/evaluate.hpp"

#include <algorithm>
#include <thread>

#include "host-sim/evaluate/figures.hpp"
#include "host-sim/python/bindings/bindings.hpp"
#include "host-sim/replay/observers.hpp"
#include "model/files/error.hpp"

namespace smaservo::python {
namespace {

/// Throws ValueError for a name that is not among `known`.
void require_known(const char* argument, const std::vector<std::string>& names,
                   const std::vector<std::string>& known) {
  for (const std::string& name : names) {
    if (std::ranges::find(known, name) == known.end()) {
      std::string all;
      for (const std::string& one : known) {
        all += (all.empty() ? "" : ", ") + one;
      }
      throw py::value_error(fmt::format("{}: '{}' must be one of {}", argument, name, all));
    }
  }
}

std::vector<std::string> names_of_rows() {
  std::vector<std::string> all;
  for (const evaluate::EvaluationRow& row : evaluate::evaluation_rows()) {
    all.emplace_back(row.name);
  }
  return all;
}

std::vector<std::string> names_of_observers() {
  std::vector<std::string> all;
  for (const replay::ObserverKind& kind : replay::observer_kinds()) {
    all.emplace_back(kind.name);
  }
  return all;
}

void add_figures(py::dict& to, int runs, const std::vector<evaluate::Figure>& figures) {
  to["runs"] = runs;
  py::list missed;
  for (const evaluate::Figure& figure : figures) {
    to[py::str(std::string(figure.name))] = figure.value;
    if (figure.missed()) {
      missed.append(std::string(figure.name));
    }
  }
  to["missed"] = missed;
}

py::list table_of(const evaluate::Evaluation& evaluation) {
  py::list all;
  for (const evaluate::ObserverEvaluation& observer : evaluation.observers) {
    for (const evaluate::RowResult& row : observer.rows) {
      py::dict one;
      one["observer"] = observer.observer;
      one["row"] = std::string(evaluate::row_of(row).name);
      add_figures(one, row.all.runs, evaluate::row_figures(observer, row));
      py::dict families;
      for (const auto& [family, figures] : row.by_family) {
        py::dict own;
        add_figures(own, figures.runs, evaluate::row_figures(observer, row, family));
        families[py::str(std::string(hal::family_name(family)))] = own;
      }
      one["families"] = families;
      all.append(one);
    }
  }
  return all;
}

py::list evaluate_rows(evaluate::EvaluateOptions options, const py::object& progress) {
  options.progress = [&](std::string_view stage, std::size_t done, std::size_t total) {
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) {
      throw py::error_already_set();
    }
    if (!progress.is_none()) {
      progress(std::string(stage), done, total);
    }
  };
  evaluate::Evaluation evaluation;
  {
    const py::gil_scoped_release no_gil;
    evaluation = evaluate::evaluate(options);
  }
  return table_of(evaluation);
}

}  // namespace

void add_evaluate(py::module_& module) {
  module.def("observer_names", &names_of_observers);
  module.def("evaluation_row_names", &names_of_rows);
  module.def("evaluate_rows", [](int units, int runs, const std::vector<std::string>& rows,
                                 const std::vector<std::string>& observers,
                                 const std::vector<std::string>& programs, const std::string& wires,
                                 const py::object& settings, std::uint64_t seed, int threads,
                                 const py::object& progress) {
    if (units < 1) {
      refuse("units", units, "1 or more");
    }
    if (runs < 0) {
      refuse("runs", runs, "0 (each row's own number) or more");
    }
    require_known("rows", rows, names_of_rows());
    require_known("observers", observers, names_of_observers());
    evaluate::EvaluateOptions options;
    options.units = units;
    options.runs = runs;
    options.rows = rows;
    options.observers = observers;
    options.programs = programs;
    options.wires = wires;
    options.settings = overrides_of(settings);
    options.seed = seed;
    options.threads =
        threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    return evaluate_rows(std::move(options), progress);
  });
}

}  // namespace smaservo::python
