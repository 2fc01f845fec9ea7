// Whole traces at once: read(), replay(), simulate(). smaservo/__init__.py calls these functions
// with arrays that it has checked.

#include "host-sim/python/bindings/tables.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <stdexcept>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "firmware/bench/scenario/scenario.hpp"
#include "host-sim/checks/findings.hpp"
#include "host-sim/replay/rows/reading_loop.hpp"
#include "host-sim/simulate/closed_loop_run.hpp"
#include "host-sim/simulate/simulate.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/wire/wire_plant.hpp"

namespace smaservo::python {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t most_checked = std::size_t{1} << 16;
constexpr std::size_t rows_between_signals = std::size_t{1} << 16;

/// A header as a file would have it: a name with a comma would be two.
std::string header_of(const std::vector<std::string>& names) {
  std::string header;
  for (const std::string& name : names) {
    header += header.empty() ? "" : ",";
    for (const char letter : name) {
      header += letter == ',' || letter == '\n' ? ';' : letter;
    }
  }
  return header;
}

/// An array that a loop without GIL fills.
class Filled {
 public:
  explicit Filled(std::size_t rows)
      : array_(static_cast<py::ssize_t>(rows)), to_(array_.mutable_data()) {}
  void set(std::size_t row, double value) { to_[row] = value; }
  const Array& array() const { return array_; }

 private:
  Array array_;
  double* to_;
};

struct ReplayInput {
  std::string observer;
  std::optional<double> load_N, stress_Pa, ambient_K;
  std::vector<std::string> allowed;
};

/// The load of rows that have none; NaN where they have.
double default_load_N(const ReplayInput& in, const hal::TraceColumns& columns, double area_m2) {
  if (columns.has(hal::Column::load) || columns.has(hal::Column::stress)) {
    return nan;
  }
  if (!in.load_N && !in.stress_Pa) {
    throw std::invalid_argument(
        "load_N: is missing, and the data have neither load_N nor stress_Pa");
  }
  return in.load_N ? *in.load_N : *in.stress_Pa * area_m2;
}

py::dict replay_rows(const files::WireDescription& wire, const std::vector<std::string>& names,
                     const std::vector<Array>& arrays, const std::vector<std::string>& renames,
                     const py::object& settings, const ReplayInput& in) {
  hal::TraceOptions options;
  options.renames = renames;
  Table table(names, arrays, options);
  const hal::TraceColumns& columns = table.columns();
  for (const auto& [column, name] :
       {std::pair{hal::Column::time, "time_s"}, std::pair{hal::Column::current, "current_A"},
        std::pair{hal::Column::voltage, "voltage_V"}}) {
    if (!columns.has(column)) {
      throw std::invalid_argument(
          fmt::format("{}: is missing; there are {}", name, files::printable(header_of(names))));
    }
  }
  const double area_m2 = wire.wire.geometry.area_m2();
  const double load_N = default_load_N(in, columns, area_m2);
  replay::ReadingLoop loop(wire.wire, replay::parse_run_settings(overrides_of(settings)),
                           {in.observer});
  const std::size_t rows = table.rows();
  Filled time_s(rows), strain(rows), strain_sd(rows), temperature_K(rows), martensite(rows),
      r_phase(rows), resistance_ohm(rows), model_ohm(rows);
  py::array_t<bool> valid(static_cast<py::ssize_t>(rows));
  py::array_t<std::uint8_t> health(static_cast<py::ssize_t>(rows));
  bool* const valid_to = valid.mutable_data();
  std::uint8_t* const health_to = health.mutable_data();
  std::uint64_t restarts = 0;
  checks::Judgement judgement;
  {
    const py::gil_scoped_release no_gil;
    checks::Recorder recorder(table.known(), "index", most_checked);
    hal::TraceRow row{};
    std::size_t found = 0;
    for (std::size_t i = 0; table.next(row); ++i) {
      if (i % rows_between_signals == rows_between_signals - 1) {
        check_signals();
      }
      recorder.add(row);
      const double newton = columns.has(hal::Column::load)     ? row[hal::Column::load]
                            : columns.has(hal::Column::stress) ? row[hal::Column::stress] * area_m2
                                                               : load_N;
      const double ambient_K = in.ambient_K                        ? *in.ambient_K
                               : columns.has(hal::Column::ambient) ? row[hal::Column::ambient]
                                                                   : room_K;
      restarts += loop.add({row[hal::Column::current], row[hal::Column::voltage], newton},
                           {row.time_ns(), 0, ambient_K})
                      ? 1U
                      : 0U;
      const Measurement<double>& m = loop.measurement();
      const Estimate<double> e = loop.estimate();
      time_s.set(i, row[hal::Column::time]);
      strain.set(i, e.strain);
      strain_sd.set(i, e.strain_sd);
      temperature_K.set(i, e.temperature_K);
      martensite.set(i, e.martensite);
      r_phase.set(i, e.r_phase);
      resistance_ohm.set(i, m.resistance_valid ? m.resistance_ohm : nan);
      model_ohm.set(i, e.resistance_model_ohm);
      valid_to[i] = m.resistance_valid;
      health_to[i] = static_cast<std::uint8_t>(e.health);
      found += m.resistance_valid ? 1U : 0U;
    }
    checks::Record record = recorder.finish("data", wire.wire.geometry);
    record.kind = checks::RunKind::joule;
    judgement = checks::judge_mistakes(
        record, {wire.wire.geometry, loop.sensors().lead_resistance_ohm}, in.allowed);
    if (!judgement.error.empty()) {
      throw files::UserError(judgement.error);
    }
    if (found == 0) {
      throw files::UserError(
          fmt::format("data: no row has a valid resistance, so the estimate follows the power "
                      "alone; are length "
                      "and diameter of {} and the units of current and voltage right?",
                      wire.name));
    }
  }
  py::dict all;
  all["time_s"] = time_s.array();
  all["strain"] = strain.array();
  all["strain_sd"] = strain_sd.array();
  all["temperature_K"] = temperature_K.array();
  all["martensite"] = martensite.array();
  all["r_phase"] = r_phase.array();
  all["resistance_ohm"] = resistance_ohm.array();
  all["resistance_model_ohm"] = model_ohm.array();
  all["valid"] = valid;
  all["health"] = health;
  py::dict result;
  result["columns"] = all;
  result["restarts"] = restarts;
  result["warnings"] = judgement.warnings;
  return result;
}

/// The inputs of simulate(), of equal length.
struct SimulateInput {
  const double *time_s, *current_A, *load_N, *ambient_K, *draught;
};

[[noreturn]] void refuse_row(const char* name, std::size_t row, double value, const char* allowed) {
  throw std::invalid_argument(fmt::format("{}[{}] = {}: must be {}", name, row, value, allowed));
}

void check_row(const SimulateInput& in, std::size_t i) {
  const auto finite = [&](const char* name, double value) {
    if (!std::isfinite(value)) {
      refuse_row(name, i, value, "a finite number");
    }
  };
  finite("time_s", in.time_s[i]);
  finite("current_A", in.current_A[i]);
  finite("load_N", in.load_N[i]);
  const auto positive = [&](const char* name, double value) {
    if (!(value > 0 && std::isfinite(value))) {
      refuse_row(name, i, value, "greater than 0 and finite");
    }
  };
  positive("ambient_K", in.ambient_K[i]);
  positive("draught", in.draught[i]);
  const double dt_s = i == 0 ? 1 : in.time_s[i] - in.time_s[i - 1];
  if (!(dt_s > 0 && dt_s <= WirePlant<double>::longest_update_s)) {
    refuse_row(
        "time_s", i, in.time_s[i],
        fmt::format("later than the {} before it, by at most 60 s", in.time_s[i - 1]).c_str());
  }
}

py::dict simulate_rows(const files::WireDescription& wire, const Array& time_s,
                       const Array& current_A, const Array& load_N, const Array& ambient_K,
                       const Array& draught) {
  const auto rows = static_cast<std::size_t>(time_s.size());
  const SimulateInput in{time_s.data(), current_A.data(), load_N.data(), ambient_K.data(),
                         draught.data()};
  Filled strain(rows), ohm(rows), kelvin(rows), martensite(rows), r_phase(rows), volt(rows);
  {
    const py::gil_scoped_release no_gil;
    check_row(in, 0);
    WirePlant<double> plant(wire.wire, in.load_N[0], in.ambient_K[0]);
    WireOutput<double> now = plant.output();
    for (std::size_t i = 0; i < rows; ++i) {
      check_row(in, i);
      if (i % rows_between_signals == rows_between_signals - 1) {
        check_signals();
      }
      if (i > 0) {
        const std::size_t before = i - 1;
        now = plant.update(
            {in.current_A[before], in.load_N[before], in.ambient_K[before], in.draught[before]},
            in.time_s[i] - in.time_s[before]);
        if (std::isnan(now.strain)) {
          refuse_row("current_A", before, in.current_A[before],
                     "such that the wire's state stays finite");
        }
      }
      strain.set(i, now.strain);
      ohm.set(i, now.resistance_ohm);
      kelvin.set(i, now.temperature_K);
      martensite.set(i, now.martensite);
      r_phase.set(i, now.r_phase);
      volt.set(i, in.current_A[i] * now.resistance_ohm);
    }
  }
  py::dict all;
  all["time_s"] = time_s;
  all["current_A"] = current_A;
  all["voltage_V"] = volt.array();
  all["load_N"] = load_N;
  all["strain"] = strain.array();
  all["resistance_ohm"] = ohm.array();
  all["temperature_K"] = kelvin.array();
  all["martensite"] = martensite.array();
  all["r_phase"] = r_phase.array();
  return all;
}

/// The fields of the columns that a reader keeps as text, as they are read.
class Texts {
 public:
  explicit Texts(const hal::TraceReader& trace)
      : positions_(trace.unknown()), fields_(positions_.size()) {}

  void add(std::string_view row) {
    std::size_t column = 0, at = 0;
    for (std::size_t k = 0; k < positions_.size(); ++k) {
      for (; column < positions_[k]; ++column) {
        at = row.find(',', at) + 1;
      }
      fields_[k].emplace_back(row.substr(at, std::min(row.find(',', at), row.size()) - at));
    }
  }

  /// Numbers where all fields are numbers or empty, and texts otherwise.
  static py::object column(const std::vector<std::string>& fields) {
    Filled numbers(fields.size());
    bool any = false;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      double value = nan;
      const char* const stop = fields[i].data() + fields[i].size();
      const auto [end, error] = std::from_chars(fields[i].data(), stop, value);
      if (!fields[i].empty() && (error != std::errc{} || end != stop)) {
        return text_column(fields);
      }
      any = any || !fields[i].empty();
      numbers.set(i, fields[i].empty() ? nan : value);
    }
    return any ? py::object(numbers.array()) : text_column(fields);
  }
  const std::vector<std::vector<std::string>>& fields() const { return fields_; }

 private:
  static py::object text_column(const std::vector<std::string>& fields) {
    py::list all;
    for (const std::string& field : fields) {
      all.append(py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
          field.data(), static_cast<py::ssize_t>(field.size()), "backslashreplace")));
    }
    return all;
  }

  std::vector<std::size_t> positions_;
  std::vector<std::vector<std::string>> fields_;
};

py::dict read_file(const std::string& path, const hal::TraceOptions& options) {
  std::optional<hal::TraceReader> trace;
  std::optional<Texts> texts;
  std::vector<hal::Column> columns;
  std::vector<std::vector<double>> values;
  std::vector<double> pieces;
  {
    const py::gil_scoped_release no_gil;
    trace.emplace(path, options);
    texts.emplace(*trace);
    for (std::size_t k = 0; k < hal::column_count; ++k) {
      const auto column = static_cast<hal::Column>(k);
      if (trace->has(column) || (column == hal::Column::time && trace->timed())) {
        columns.push_back(column);
      }
    }
    values.resize(columns.size());
    hal::TraceRow row{};
    for (std::size_t i = 1; trace->next(row); ++i) {
      if (i % rows_between_signals == 0) {
        check_signals();
      }
      for (std::size_t k = 0; k < columns.size(); ++k) {
        values[k].push_back(row[columns[k]]);
      }
      pieces.push_back(static_cast<double>(row.piece));
      texts->add(row.text);
    }
  }
  if (pieces.empty()) {
    throw files::UserError(fmt::format("{}: has no usable row", path));
  }
  py::dict all;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    all[py::str(hal::si_name(columns[k]))] =
        Array(static_cast<py::ssize_t>(values[k].size()), values[k].data());
  }
  for (std::size_t k = 0; k < texts->fields().size(); ++k) {
    std::string name = files::printable(trace->names()[trace->unknown()[k]]);
    while (all.contains(name)) {
      name += '_';
    }
    all[py::str(name)] = Texts::column(texts->fields()[k]);
  }
  if (pieces.back() > 0) {
    all["piece"] = Array(static_cast<py::ssize_t>(pieces.size()), pieces.data());
  }
  py::dict result;
  result["columns"] = all;
  result["notes"] = notes_of(*trace);
  return result;
}

/// Writes what `host-sim simulate` writes.
void write_scenario(const std::string& path, const std::string& out) {
  const py::gil_scoped_release no_gil;
  if (bench::is_closed_loop(path)) {
    simulate::run_closed_loop(bench::load_closed_loop(path), {.out = out});
    return;
  }
  const bench::Scenario scenario = bench::load_scenario(path);
  hal::TraceFile file(out, {"host-sim simulate", path});
  simulate::simulate(scenario, file);
  file.commit();
}

}  // namespace

Table::Table(const std::vector<std::string>& names, const std::vector<Array>& arrays,
             const hal::TraceOptions& options)
    : columns_(header_of(names), options, "data"), numbers_(names.size()) {
  for (std::size_t k = 0; k < names.size(); ++k) {
    values_.emplace_back(arrays[k].data(), static_cast<std::size_t>(arrays[k].size()));
    rows_ = std::max(rows_, values_[k].size());
    if (std::ranges::find(columns_.unknown(), k) == columns_.unknown().end()) {
      used_.push_back(k);
      if (values_[k].empty()) {
        throw py::type_error(
            fmt::format("{}: must be numbers, and is something else", files::printable(names[k])));
      }
    }
  }
}

std::vector<hal::Column> Table::known() const {
  std::vector<hal::Column> all;
  for (std::size_t k = 0; k < hal::column_count; ++k) {
    if (columns_.has(static_cast<hal::Column>(k))) {
      all.push_back(static_cast<hal::Column>(k));
    }
  }
  return all;
}

bool Table::next(hal::TraceRow& row) {
  if (at_ == rows_) {
    return false;
  }
  for (const std::size_t k : used_) {
    numbers_[k] = values_[k][at_];
  }
  if (const auto bad = columns_.take_numbers(numbers_, row)) {
    throw std::invalid_argument(fmt::format(
        "{}[{}]: {}", files::printable(columns_.names()[bad->column]), at_, bad->reason));
  }
  row.number = row.line = at_;
  row.piece = 0;
  if (columns_.has(hal::Column::time)) {
    const double time_s = row[hal::Column::time];
    if (at_ > 0 && !(last_s_ < time_s)) {
      throw std::invalid_argument(
          fmt::format("{}[{}] = {}: must be greater than the {} before it",
                      files::printable(columns_.names()[columns_.position(hal::Column::time)]), at_,
                      numbers_[columns_.position(hal::Column::time)],
                      values_[columns_.position(hal::Column::time)][at_ - 1]));
    }
    last_s_ = time_s;
  }
  ++at_;
  return true;
}

hal::TraceOptions trace_options(bool lenient, std::optional<double> period_s,
                                const std::vector<std::string>& columns) {
  if (period_s && !(*period_s >= 1e-6 && *period_s <= 1e6)) {
    refuse("period_s", *period_s, "1e-06 to 1e+06");
  }
  hal::TraceOptions options;
  options.lenient = lenient;
  options.period_s = period_s.value_or(0);
  options.renames = columns;
  return options;
}

py::dict notes_of(const hal::TraceReader& trace) {
  const auto escaped = [](const std::vector<std::string>& texts) {
    py::list all;
    for (const std::string& text : texts) {
      all.append(files::printable(text));
    }
    return all;
  };
  py::dict notes;
  notes["read_as"] = files::printable(trace.read_as());
  notes["hints"] = escaped(trace.hints());
  notes["skipped"] = trace.skipped();
  notes["complaints"] = escaped(trace.complaints());
  notes["clock_notes"] = escaped(trace.clock_notes());
  notes["repeated_headers"] = trace.repeated_headers();
  notes["strays"] = trace.strays();
  return notes;
}

void add_tables(py::module_& module) {
  module.def("replay_rows",
             [](const files::WireDescription& wire, const std::vector<std::string>& names,
                const std::vector<Array>& arrays, const std::vector<std::string>& columns,
                const std::string& observer, std::optional<double> load_N,
                std::optional<double> stress_Pa, std::optional<double> ambient_K,
                const py::object& settings, const std::vector<std::string>& allow) {
               return replay_rows(wire, names, arrays, columns, settings,
                                  {observer, load_N, stress_Pa, ambient_K, allow});
             });
  module.def("simulate_rows", &simulate_rows);
  module.def("read_file", [](const std::string& path, bool lenient, std::optional<double> period_s,
                             const std::vector<std::string>& columns, bool device) {
    hal::TraceOptions options = trace_options(lenient, period_s, columns);
    options.resistance_and_power = !device;
    options.device = device;
    return read_file(path, options);
  });
  module.def("write_scenario", &write_scenario);
}

}  // namespace smaservo::python
