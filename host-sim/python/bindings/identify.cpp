// smaservo.identify()

#include <algorithm>
#include <thread>

#include "host-sim/checks/findings.hpp"
#include "host-sim/identify/fitted_wire.hpp"
#include "host-sim/identify/report.hpp"
#include "host-sim/python/bindings/tables.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::python {
namespace {

/// A run as smaservo/__init__.py hands it over: a file, or columns.
struct Source {
  std::string name;
  std::string path;  ///< empty: the columns
  std::vector<std::string> names;
  std::vector<Array> arrays;
};

Source source_of(const py::handle& run) {
  const auto [name, path, names, arrays] = run.cast<
      std::tuple<std::string, std::string, std::vector<std::string>, std::vector<Array>>>();
  return {name, path, names, arrays};
}

/// Takes all rows; `Rows` is a reader of files or a Table.
template <class Rows>
void take_rows(Rows& rows, checks::Recorder& recorder) {
  hal::TraceRow row{};
  while (rows.next(row)) {
    recorder.add(row);
  }
}

checks::Record record_of(const Source& source, const identify::RunOptions& options,
                         std::vector<std::string>& warnings) {
  if (source.path.empty()) {
    Table table(source.names, source.arrays, options.trace);
    checks::Recorder recorder(table.known(), "index");
    take_rows(table, recorder);
    return recorder.finish(source.name, options.geometry);
  }
  hal::TraceReader trace(source.path, options.trace);
  checks::Recorder recorder(trace);
  take_rows(trace, recorder);
  for (const std::string& complaint : trace.complaints()) {
    warnings.push_back(fmt::format("{}: skipped: {}", source.name, complaint));
  }
  for (const std::string& hint : trace.hints()) {
    warnings.push_back(fmt::format("{}: {}", source.name, hint));
  }
  return recorder.finish(source.name, options.geometry);
}

identify::Run read_run(const Source& source, const identify::RunOptions& options,
                       std::vector<std::string>& warnings) {
  identify::Run run = identify::run_of(record_of(source, options, warnings), options);
  const checks::Judgement judgement =
      checks::judge_mistakes(run, {options.geometry}, options.allowed);
  if (!judgement.error.empty()) {
    throw files::UserError(judgement.error);
  }
  warnings.insert(warnings.end(), judgement.warnings.begin(), judgement.warnings.end());
  return run;
}

/// Calls Python between the steps of a fit; what it raises ends the fit, and is thrown afterwards.
class Progress {
 public:
  explicit Progress(py::object callback) : callback_(std::move(callback)) {}

  bool go_on(const identify::FitProgress& at) {
    const py::gil_scoped_acquire gil;
    try {
      if (PyErr_CheckSignals() != 0) {
        throw py::error_already_set();
      }
      if (!callback_.is_none()) {
        const py::object answer = callback_(at.stage, at.share, at.cost);
        return !answer.is(py::bool_(false));
      }
    } catch (const py::error_already_set&) {
      raised_ = std::current_exception();
      return false;
    }
    return true;
  }
  void rethrow() const {
    if (raised_) {
      std::rethrow_exception(raised_);
    }
  }

 private:
  py::object callback_;
  std::exception_ptr raised_;
};

py::dict quality(const identify::FitQuality& q) {
  py::dict all;
  all["rms"] = q.rms;
  all["p95"] = q.p95;
  all["max"] = q.maximum;
  all["count"] = q.count;
  return all;
}

py::list fitted_runs(const identify::FitResult& fit) {
  py::list all;
  for (const identify::FittedRun& run : fit.runs) {
    py::dict one;
    one["name"] = files::printable(run.name);
    one["kind"] = std::string(identify::name_of(run.kind));
    one["strain"] = quality(run.strain);
    one["resistance"] = quality(run.resistance);
    one["resistance_given_strain"] = quality(run.given_strain);
    one["power"] = quality(run.power);
    one["stress_Pa"] = quality(run.stress_Pa);
    all.append(one);
  }
  return all;
}

py::list fitted_parameters(const identify::FitResult& fit) {
  py::list all;
  for (const identify::FittedParameter& fitted : fit.parameters) {
    const identify::Figure figure = identify::figure(fitted);
    py::dict one;
    one["key"] = fitted.parameter.key;
    one["unit"] = std::string(fitted.parameter.unit);
    one["value"] = figure.value;
    one["sd"] = figure.sd;
    one["prior"] = figure.prior;
    one["prior_sd"] = figure.prior_sd;
    one["determined"] = fitted.determined;
    all.append(one);
  }
  return all;
}

py::dict identify_runs(const files::WireDescription& from, const py::list& runs,
                       const std::string& name, const identify::RunOptions& options, int threads,
                       bool circuit, const std::string& structure, const py::object& progress) {
  std::vector<Source> sources;
  for (const py::handle run : runs) {
    sources.push_back(source_of(run));
  }
  Progress calls(progress);
  identify::Identification all;
  std::vector<std::string> warnings;
  {
    const py::gil_scoped_release no_gil;
    for (const Source& source : sources) {
      all.runs.push_back(read_run(source, options, warnings));
    }
    identify::FitOptions fit;
    fit.circuit = circuit;
    fit.structure = identify::structure_named(structure);
    fit.threads =
        threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    fit.proceed = [&](const identify::FitProgress& at) { return calls.go_on(at); };
    all.fit = identify::fit_wire(from.wire, all.runs, fit);
  }
  calls.rethrow();
  all.wire = identify::fitted_wire(from, all.fit, name);
  all.from = from.name;
  all.out = name;
  for (const identify::Run& run : all.runs) {
    all.classics.push_back(identify::fit_classics(run));
  }
  py::dict result;
  result["wire"] = all.wire;
  result["parameters"] = fitted_parameters(all.fit);
  result["runs"] = fitted_runs(all.fit);
  result["strain_rms"] = py::cast(identify::joint_strain_rms(all.fit));
  result["converged"] = all.fit.converged;
  result["interrupted"] = all.fit.interrupted;
  result["iterations"] = all.fit.iterations;
  result["summary"] = files::printable_lines(identify::fit_summary(all));
  result["warnings"] = warnings;
  return result;
}

}  // namespace

void add_identify(py::module_& module) {
  module.def("identify_runs",
             [](const files::WireDescription& from, const py::list& runs, const std::string& name,
                std::optional<double> load_N, std::optional<double> stress_Pa,
                const std::vector<std::string>& columns, const std::vector<std::string>& allow,
                bool lenient, int threads, bool circuit, const std::string& structure,
                bool imposed_strain, const py::object& progress) {
               identify::RunOptions options{from.wire.geometry, stress_Pa, load_N,
                                            trace_options(lenient, std::nullopt, columns), allow};
               options.trace.resistance_and_power = true;
               options.imposed_strain = imposed_strain;
               return identify_runs(from, runs, name, options, threads, circuit, structure,
                                    progress);
             });
}

}  // namespace smaservo::python
