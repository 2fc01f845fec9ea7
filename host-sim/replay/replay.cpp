#include "host-sim/replay/replay.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>

#include "hal/replay/board.hpp"
#include "host-sim/checks/findings.hpp"
#include "host-sim/how_read.hpp"
#include "host-sim/replay/estimate_file.hpp"
#include "host-sim/replay/rows/reading_loop.hpp"
#include "model/files/error.hpp"
#include "model/files/progress.hpp"
#include "model/units.hpp"
#include "model/wire/plant.hpp"

namespace smaservo::replay {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double lost_percent = 20;
constexpr double settling_s = 1;

/// The strain that the trace knows to be true, or NaN.
class Reference {
 public:
  Reference(const hal::TraceReader& trace, double length_m)
      : strain_(trace.has(hal::Column::strain_ref)),
        displacement_(!strain_ && trace.has(hal::Column::displacement)),
        length_m_(length_m) {}

  bool known() const { return strain_ || displacement_; }

  /// A displacement has no zero of its own: it starts where the first estimate is.
  double of(const hal::TraceRow& row, double first_estimate) {
    if (strain_) {
      return row[hal::Column::strain_ref];
    }
    if (!displacement_) {
      return nan;
    }
    if (std::isnan(zero_)) {
      zero_ = first_estimate + row[hal::Column::displacement] / length_m_;
    }
    return zero_ - row[hal::Column::displacement] / length_m_;
  }

 private:
  bool strain_;
  bool displacement_;
  double length_m_;
  double zero_ = nan;
};

/// Takes the estimates of a run to the file, the statistics and the plots.
class Sink {
 public:
  Sink(const ReplayOptions& options, const hal::TraceReader& trace, ReplayResult& result)
      : result_(result),
        name_(options.trace),
        reference_(trace, options.wire.wire.geometry.length_m),
        stroke_(options.wire.wire.nominal_stroke) {
    result_.has_reference = reference_.known();
    result_.timed = trace.timed();
    if (!options.out.empty()) {
      std::vector<std::string> passed;
      for (const std::size_t position : trace.unknown()) {
        passed.push_back(trace.names()[position]);
      }
      file_ = std::make_unique<EstimateFile>(options.out, options.trace, reference_.known(), passed,
                                             trace.unknown());
    }
  }

  /// `row` lacks only its reference; `point` has only the inputs, which nothing but plots shows.
  void add(EstimateRow row, const hal::TraceRow& source, report::PlotPoint point) {
    row.strain_ref = reference_.of(source, row.strain);
    first_s_ = std::isnan(first_s_) ? row.time_s : first_s_;
    started_s_ = std::isnan(started_s_) ? row.time_s : started_s_;
    add_error(0, row.strain, row.strain_ref, row.time_s);
    if (file_) {
      file_->add(row, source.text);
    }
    point.time_s = std::isnan(row.time_s) ? static_cast<double>(result_.rows) : row.time_s;
    point.strain_percent = 100 * row.strain;
    point.strain_sd_percent = 100 * row.strain_sd;
    point.strain_ref_percent = 100 * row.strain_ref;
    point.error_percent = 100 * (row.strain - row.strain_ref) / stroke_;
    point.resistance_ohm = row.resistance_ohm;
    point.resistance_model_ohm = row.resistance_model_ohm;
    point.temperature_degC = row.temperature_K - zero_degC_K;
    point.temperature_ref_degC = source[hal::Column::temperature] - zero_degC_K;
    point.martensite = row.martensite;
    point.r_phase = row.r_phase;
    result_.series.add(point);
    const std::array values{row.strain, point.temperature_degC, row.martensite, row.resistance_ohm};
    for (std::size_t i = 0; i < values.size(); ++i) {
      result_.columns[i].add(values[i]);
    }
    result_.invalid += row.valid ? 0U : 1U;
    ++result_.rows;
    last_ref_ = row.strain_ref;
    last_s_ = row.time_s;
  }

  /// The observers have started again with the next row, and have their time to settle.
  void restart() {
    started_s_ = nan;
    ++result_.restarts;
  }

  /// The estimate of another observer for the row that was added last.
  void compare(std::size_t observer, double strain) {
    add_error(observer, strain, last_ref_, last_s_);
  }

  void finish(const hal::TraceReader& trace) {
    say_what_was_skipped(name_, trace);
    result_.skipped = trace.skipped();
    result_.bytes = trace.bytes();
    result_.complaints = trace.complaints();
    result_.clock_notes = trace.clock_notes();
    if (result_.rows == 0) {
      throw files::UserError(fmt::format("{}: has no usable row", name_));
    }
    result_.duration_s = std::isnan(last_s_) ? 0 : last_s_ - first_s_;
    if (file_) {
      file_->commit();
    }
  }

 private:
  void add_error(std::size_t observer, double strain, double reference, double time_s) {
    if (std::isnan(reference)) {
      return;
    }
    const double percent = 100 * (strain - reference) / stroke_;
    ObserverResult& result = result_.observers[observer];
    result.error.add(percent);
    const bool settled = std::isnan(time_s) || time_s - started_s_ > settling_s;
    result.lost = result.lost || (settled && !(std::abs(percent) <= lost_percent));
  }

  ReplayResult& result_;
  std::string name_;
  Reference reference_;
  double stroke_;
  std::unique_ptr<EstimateFile> file_;
  double first_s_ = nan, started_s_ = nan;
  double last_s_ = nan;
  double last_ref_ = nan;
};

/// The load from the options for a trace without load and stress; NaN for a trace with them.
double default_load_N(const ReplayOptions& options, const hal::TraceReader& trace) {
  if (trace.has(hal::Column::load) || trace.has(hal::Column::stress)) {
    return nan;
  }
  if (options.load_N) {
    return *options.load_N;
  }
  if (options.stress_Pa) {
    return *options.stress_Pa * options.wire.wire.geometry.area_m2();
  }
  throw files::UserError(fmt::format(
      "{}: has neither load_N nor stress_MPa; give the load with --load-N or --stress-MPa",
      options.trace));
}

/// So many rows are kept for the checks.
constexpr std::size_t most_checked = std::size_t{1} << 16;

void check_record(const ReplayOptions& options, checks::Recorder recorder, checks::RunKind kind,
                  double lead_resistance_ohm) {
  const std::string name = options.trace == "-" ? "standard input" : options.trace;
  const Geometry<double>& geometry = options.wire.wire.geometry;
  checks::Record record = recorder.finish(name, geometry);
  record.kind = kind;
  checks::refuse_mistakes(record, {geometry, lead_resistance_ohm}, options.allowed);
}

/// Temperature and stress are known: the kinetics alone, without heat balance or resistance.
void replay_bath(const ReplayOptions& options, hal::TraceReader trace, ReplayResult& result) {
  using K = ThreePhase<double>;
  const auto model = plant_params(options.wire.wire);
  const double area_m2 = options.wire.wire.geometry.area_m2();
  const double load_N = default_load_N(options, trace);
  result.open_loop = true;
  result.observers = {{"model", {}, false}};
  Sink sink(options, trace, result);
  files::Progress progress("replay", trace.file_size());
  K::State state{};
  hal::TraceRow row{};
  std::uint32_t piece = 0;
  checks::Recorder recorder(trace, most_checked);
  while (trace.next(row)) {
    recorder.add(row);
    const double stress_Pa = trace.has(hal::Column::stress) ? row[hal::Column::stress]
                             : trace.has(hal::Column::load) ? row[hal::Column::load] / area_m2
                                                            : load_N / area_m2;
    const Drive<double> drive{row[hal::Column::temperature], stress_Pa};
    if (result.rows == 0 || row.piece != piece) {
      if (result.rows > 0) {
        sink.restart();
      }
      piece = row.piece;
      state = K::rest(model.kinetics, drive);
    } else {
      K::advance(model.kinetics, state, drive);
    }
    // In a bath the ends are as warm as the rest.
    const Phases<double> z = K::phases(state);
    const double elongation = strain(model.material, z, stress_Pa);
    const double ohm = resistance_ohm(resistivity(model.material, z, drive).value,
                                      model.length_per_area_1_m, elongation);
    report::PlotPoint point{};
    point.current_A = nan;
    point.stress_MPa = stress_Pa * 1e-6;
    sink.add({.time_s = row[hal::Column::time],
              .strain = elongation,
              .strain_sd = nan,
              .temperature_K = drive.temperature_K,
              .martensite = z.martensite,
              .r_phase = z.r_phase,
              .resistance_ohm = nan,
              .resistance_model_ohm = ohm,
              .valid = true,
              .strain_ref = nan},
             row, point);
    progress.update(trace.bytes());
  }
  check_record(options, std::move(recorder), checks::RunKind::bath, 0);
  sink.finish(trace);
}

/// The air that observers start from with this row.
double ambient_K(const ReplayOptions& options, const hal::ReplayBoard& board) {
  if (options.ambient_K) {
    return *options.ambient_K;
  }
  return board.trace().has(hal::Column::ambient) ? board.row()[hal::Column::ambient] : room_K;
}

void replay_electrical(const ReplayOptions& options, const RunSettings& settings,
                       hal::TraceReader reader, ReplayResult& result) {
  const Wire<double>& wire = options.wire.wire;
  const double load_N = default_load_N(options, reader);
  Sink sink(options, reader, result);
  std::vector<std::string> observers;
  for (const std::string& name : options.observers) {
    if (observers.empty() || result.has_reference) {
      observers.push_back(name);
      result.observers.push_back({name, {}, false});
    }
  }
  files::Progress progress("replay", reader.file_size());
  checks::Recorder recorder(reader, most_checked);
  hal::ReplayBoard board(std::move(reader), load_N, wire.geometry.area_m2());
  ReadingLoop loop(wire, settings, observers);
  hal::Frame frame{};
  while (board.read(frame) == hal::ReadStatus::frame) {
    recorder.add(board.row());
    if (loop.add({frame.current_A, frame.voltage_V, frame.load_N},
                 {frame.time_ns, board.row().piece, ambient_K(options, board)})) {
      sink.restart();
    }
    const Measurement<double>& m = loop.measurement();
    const Estimate<double> e = loop.estimate();
    report::PlotPoint point{};
    point.current_A = frame.current_A;
    point.stress_MPa = m.stress_Pa * 1e-6;
    sink.add({.time_s = board.row()[hal::Column::time],
              .strain = e.strain,
              .strain_sd = e.strain_sd,
              .temperature_K = e.temperature_K,
              .martensite = e.martensite,
              .r_phase = e.r_phase,
              .resistance_ohm = m.resistance_valid ? m.resistance_ohm : nan,
              .resistance_model_ohm = e.resistance_model_ohm,
              .valid = m.resistance_valid,
              .strain_ref = nan},
             board.row(), point);
    for (std::size_t i = 1; i < observers.size(); ++i) {
      sink.compare(i, loop.estimate(i).strain);
    }
    progress.update(board.trace().bytes());
  }
  check_record(options, std::move(recorder), checks::RunKind::joule,
               loop.sensors().lead_resistance_ohm);
  sink.finish(board.trace());
}

}  // namespace

void ColumnSummary::add(double value) {
  if (std::isnan(value)) {
    ++empty;
    return;
  }
  min = std::min(min, value);
  max = std::max(max, value);
  sum += value;
  ++count;
}

ReplayResult replay(const ReplayOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  hal::TraceReader trace(options.trace, options.trace_options);
  say_how_read(options.trace, trace);
  ReplayResult result;
  const bool electrical = trace.has(hal::Column::current) && trace.has(hal::Column::voltage);
  const RunSettings settings = parse_run_settings(options.settings);
  if (electrical && trace.timed()) {
    replay_electrical(options, settings, std::move(trace), result);
  } else if (trace.has(hal::Column::temperature) && !electrical) {
    replay_bath(options, std::move(trace), result);
  } else {
    throw files::UserError(fmt::format(
        "{}: needs time_s, current_A and voltage_V (and load_N or stress_MPa), or temperature_degC "
        "and stress_MPa for the model alone; has: {}. A trace without time needs --period-s, other "
        "names --column",
        options.trace, fmt::join(trace.names(), ", ")));
  }
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  result.elapsed_s = elapsed.count();
  return result;
}

}  // namespace smaservo::replay
