#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "firmware/text/settings_file.hpp"
#include "host-sim/campaign/kinds/kinds.hpp"
#include "host-sim/hash.hpp"
#include "host-sim/identify/fit/fit.hpp"
#include "host-sim/identify/fitted_wire.hpp"
#include "host-sim/identify/report.hpp"
#include "host-sim/identify/runs/run.hpp"
#include "host-sim/shell_word.hpp"
#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/message.hpp"
#include "model/files/toml/toml_fields.hpp"

namespace smaservo::campaign {
namespace {

namespace fs = std::filesystem;

constexpr double fit_cost_s = 90;
constexpr double no_value = std::numeric_limits<double>::quiet_NaN();
constexpr const char* converged = "converged";
/// A piece's own wire, from which its fit starts, in its folder.
constexpr const char* own_wire = "wire.toml";

struct RunFile {
  std::string path, hash;
};

/// A wire of the lot.
struct Piece {
  std::string name;
  std::string start;       ///< preset or wire file
  std::string start_name;  ///< of that file without the folder in which the plan lies
  std::vector<RunFile> runs;
};

/// How all pieces are identified.
struct HowIdentified {
  std::string from, from_name;
  std::vector<std::string> settings;  ///< key=value of the wire
  std::optional<double> stress_MPa, load_N;
  std::vector<std::string> columns;
  bool circuit;

  files::WireDescription start(const Piece& piece) const {
    files::WireDescription wire = files::load_wire(piece.start, text::parse_settings(settings));
    wire.name = piece.start_name;
    return wire;
  }
};

/// All parameters that a fit may have, whichever structure it chooses.
std::vector<identify::FitParameter> all_parameters(const HowIdentified& how, const Piece& piece) {
  identify::FitVariant variant;
  variant.separate_r2a = variant.separate_r2m = variant.taper = variant.loop_order = true;
  return identify::fit_parameters(how.start(piece).wire, variant);
}

std::string column_name(const identify::FitParameter& parameter) {
  const std::string unit = parameter.unit == "%" ? "percent" : parameter.unit;
  std::string name = parameter.key + (unit.empty() ? "" : '_' + unit);
  std::ranges::replace(name, ' ', '_');
  std::ranges::replace(name, '/', '_');
  return name.starts_with("wire.") ? name.substr(5) : name;
}

/// The pieces that need somebody's attention.
class LotTable final : public Table {
 public:
  void add(const std::vector<std::string>& cells) override {
    if (cells.at(1) != converged) {
      found_ += fmt::format("{}: {}{}{}\n", cells.at(0), cells.at(1),
                            cells.at(2).empty() ? "" : ": ", cells.at(2));
    }
  }
  void add(const TrialFile& /*file*/) override {}
  std::string text() const override { return found_; }
  std::string markdown() const override { return ""; }
  std::string_view mark() const override { return ""; }

 private:
  std::string found_;
};

class Lot final : public Trials {
 public:
  Lot(HowIdentified how, std::vector<Piece> pieces)
      : how_(std::move(how)), pieces_(std::move(pieces)) {
    columns_ = {{"piece", true, true, true},    {"outcome", false, true},
                {"problem", false, true, true}, {"strain_rms_percent", false},
                {"separate_r2a", false, true},  {"separate_r2m", false, true},
                {"taper", false, true},         {"memory", false, true},
                {"loop_order", false, true},    {"mixture", false, true}};
    for (const identify::FitParameter& parameter : all_parameters(how_, pieces_.front())) {
      keys_.push_back(parameter.key);
      columns_.push_back({column_name(parameter), false});
      columns_.push_back({column_name(parameter) + "_sd", false, false, true});
    }
  }

  const std::vector<Column>& columns() const override { return columns_; }
  std::string_view main_column() const override { return "strain_rms_percent"; }
  double cost_s() const override { return fit_cost_s; }

  TrialResult run(std::uint64_t index, const Stop& stop) const override {
    const Piece& piece = pieces_.at(static_cast<std::size_t>(index));
    for (const RunFile& file : piece.runs) {
      if (hash_of(files::whole_file(file.path)) != file.hash) {
        throw files::UserError(file.path + ": has changed since the campaign was begun");
      }
    }
    try {
      return identified(piece, stop);
    } catch (const files::UserError& error) {
      // One piece with a bad record does not keep the others from being identified.
      std::string problem = files::printable(error.what());
      std::ranges::replace(problem, '\n', ' ');
      return {row_of(piece, "refused", std::move(problem), {})};
    }
  }

  std::unique_ptr<Table> table() const override { return std::make_unique<LotTable>(); }

  std::string command(std::uint64_t index) const override {
    const Piece& piece = pieces_.at(static_cast<std::size_t>(index));
    std::string line = fmt::format("host-sim identify --from {} --out {}", shell_word(piece.start),
                                   shell_word(piece.name + ".toml"));
    for (const std::string& setting : how_.settings) {
      line += " --set " + shell_word(setting);
    }
    for (const std::string& column : how_.columns) {
      line += " --column " + shell_word(column);
    }
    line += how_.stress_MPa ? fmt::format(" --stress-MPa {}", *how_.stress_MPa) : "";
    line += how_.load_N ? fmt::format(" --load-N {}", *how_.load_N) : "";
    line += how_.circuit ? " --circuit" : "";
    for (const RunFile& file : piece.runs) {
      line += ' ' + shell_word(file.path);
    }
    return line;
  }

 private:
  TrialResult identified(const Piece& piece, const Stop& stop) const {
    const files::WireDescription from = how_.start(piece);
    identify::RunOptions reading{from.wire.geometry, {}, how_.load_N, {}};
    if (how_.stress_MPa) {
      reading.stress_Pa = 1e6 * *how_.stress_MPa;
    }
    reading.trace.renames = how_.columns;
    if (piece.runs.empty()) {
      throw files::UserError("its folder has no files of runs");
    }
    std::vector<identify::Run> runs;
    runs.reserve(piece.runs.size());
    for (const RunFile& file : piece.runs) {
      runs.push_back(identify::read_run(file.path, reading));
    }
    identify::FitOptions options;
    options.circuit = how_.circuit;
    options.proceed = [&](const identify::FitProgress& /*at*/) { return !(stop && stop()); };
    const identify::FitResult fit = identify::fit_wire(from.wire, runs, options);
    if (fit.interrupted) {
      throw Stopped();
    }
    const files::WireDescription wire = identify::fitted_wire(from, fit, piece.name);
    return {row_of(piece, fit.converged ? converged : "not converged", "", fit),
            {{piece.name + ".toml", files::to_toml(wire)}}};
  }

  /// Without a fit its cells are empty.
  Row row_of(const Piece& piece, const std::string& outcome, std::string problem,
             const std::optional<identify::FitResult>& fit) const {
    Row row{piece.name, outcome, std::move(problem)};
    if (fit) {
      const std::optional<double> rms = identify::joint_strain_rms(*fit);
      const identify::FitVariant& v = fit->variant;
      row.insert(row.end(),
                 {rms ? 100 * *rms : no_value, yes_or_no(v.separate_r2a), yes_or_no(v.separate_r2m),
                  yes_or_no(v.taper), v.memory == Memory::return_point ? "return-point" : "plain",
                  yes_or_no(v.loop_order), v.mixture == Mixture::series ? "series" : "parallel"});
    } else {
      row.insert(row.end(), {no_value, "", "", "", "", "", ""});
    }
    std::map<std::string, identify::Figure> found;
    for (const identify::FittedParameter& one :
         fit ? fit->parameters : std::vector<identify::FittedParameter>()) {
      if (one.determined) {
        found.emplace(one.parameter.key, identify::figure(one));
      }
    }
    for (const std::string& key : keys_) {
      const auto at = found.find(key);
      row.emplace_back(at == found.end() ? no_value : at->second.value);
      row.emplace_back(at == found.end() ? no_value : at->second.sd);
    }
    return row;
  }

  HowIdentified how_;
  std::vector<Piece> pieces_;
  std::vector<Column> columns_;
  std::vector<std::string> keys_;  ///< of the parameters, as columns_ has them
};

std::vector<fs::path> sorted_entries(KindTable& table, const std::string& folder) {
  std::error_code error;
  std::vector<fs::path> all;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (std::ranges::any_of(name, [](unsigned char c) { return c < ' '; })) {
      table.keys().fail("folder", fmt::format("{} has a control character in its name",
                                              files::quoted(entry.path().string())));
    }
    if (!name.starts_with('.')) {
      all.push_back(entry.path());
    }
  }
  if (error) {
    table.keys().fail("folder", fmt::format("{}: {}", folder, error.message()));
  }
  std::ranges::sort(all);
  return all;
}

Piece piece_of(KindTable& table, const std::string& folder, const HowIdentified& how) {
  Piece piece{fs::path(folder).filename().string(), how.from, how.from_name, {}};
  for (const fs::path& path : sorted_entries(table, folder)) {
    const std::string name = piece.name + '/' + path.filename().string();
    if (path.filename() == own_wire) {
      piece.start = path.string();
      piece.start_name = name;
    } else if (fs::is_regular_file(path)) {
      piece.runs.push_back({path.string(), table.depends_on("folder", name, path.string())});
    }
  }
  // With its settings, and whatever other wire the file is based on.
  table.depends_on_text("start of " + piece.name, files::to_toml(how.start(piece)));
  return piece;
}

std::optional<double> number_if_given(KindTable& table, std::string_view key, double high) {
  return table.keys().has(key) ? std::optional(table.keys().number(key, 0, high)) : std::nullopt;
}

std::vector<std::string> texts_if_given(KindTable& table, std::string_view key) {
  return table.keys().has(key) ? table.keys().texts(key) : std::vector<std::string>();
}

}  // namespace

std::unique_ptr<const Trials> read_lot(KindTable& table) {
  constexpr double most_MPa = 1e4;
  constexpr double most_N = 1e5;
  const std::string folder = table.path("folder");
  const std::string from = table.keys().text("from");
  HowIdentified how{from.ends_with(".toml") ? table.path("from") : from,
                    from,
                    texts_if_given(table, "set"),
                    number_if_given(table, "stress_MPa", most_MPa),
                    number_if_given(table, "load_N", most_N),
                    texts_if_given(table, "columns"),
                    table.keys().flag("circuit", false)};
  if (how.stress_MPa && how.load_N) {
    table.keys().fail("load_N", "cannot be given with stress_MPa");
  }
  std::vector<Piece> pieces;
  for (const fs::path& path : sorted_entries(table, folder)) {
    if (fs::is_directory(path)) {
      pieces.push_back(piece_of(table, path.string(), how));
    }
  }
  if (pieces.empty()) {
    table.keys().fail("folder",
                      fmt::format("{} has no folders, one for each piece, of runs", folder));
  }
  table.has_trials(pieces.size());
  return std::make_unique<Lot>(std::move(how), std::move(pieces));
}

}  // namespace smaservo::campaign
