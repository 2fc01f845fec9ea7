#include "host-sim/record/record.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <utility>

#include "host-sim/end_by_signal.hpp"
#include "host-sim/record/card/wire_of_card.hpp"
#include "host-sim/record/contents.hpp"
#include "host-sim/record/folder.hpp"
#include "host-sim/record/readme.hpp"
#include "host-sim/temporary_folder.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::record {

namespace fs = std::filesystem;

namespace {

/// "run7" of "data/run7.csv.gz".
std::string name_of_file(const std::string& path) {
  fs::path name = fs::path(path).filename();
  for (const char* const packed : {".gz", ".zst", ".xz"}) {
    name = name.extension() == packed ? name.stem() : name;
  }
  return name.stem().string();
}

/// Names of all runs, none of which is there or given twice.
std::vector<std::string> names_of(const RecordTask& task, const Folder& folder) {
  std::vector<std::string> names;
  for (const NamedRun& run : task.runs) {
    const std::string name = run.name.empty() ? name_of_file(run.source.path) : run.name;
    try {
      folder.refuse_taken(name);
    } catch (const files::UserError& error) {
      throw files::UserError(fmt::format("{}: {}", run.source.shown, error.what()));
    }
    const auto same = std::ranges::find_if(
        names, [&](const std::string& other) { return lower_case(other) == lower_case(name); });
    if (same != names.end()) {
      throw files::UserError(
          fmt::format("{} and {}: both would be the run {}; add them one by one, with --run NAME",
                      task.runs[static_cast<std::size_t>(same - names.begin())].source.shown,
                      run.source.shown, name));
    }
    names.push_back(name);
  }
  return names;
}

/// Writes what a new folder has besides its runs.
void stage_beginning(const Folder& folder, const Card& card, const files::WireDescription& wire) {
  if (folder.is_new()) {
    folder.stage(card_name, card.text);
    folder.stage(wire_name, files::to_toml(wire));
  }
}

/// The runs of the folder with the new ones, by name.
std::vector<RunFacts> all_facts(const Folder& folder, const files::WireDescription& wire,
                                std::vector<RunFacts> added) {
  for (const std::string& run : folder.runs()) {
    added.emplace_back(run, facts_of(folder.run_path(run), wire));
  }
  std::ranges::sort(added, {}, &RunFacts::first);
  return added;
}

std::string summary(const Folder& folder, const Card& card, const std::string& preset,
                    const std::vector<RunFacts>& added) {
  const std::string name = files::printable(folder.path());
  std::string text;
  for (const auto& [run, facts] : added) {
    text +=
        fmt::format("{}/{}: {} rows, {:.4g} s, {} {}\n", name, path_of_run(run), facts.rows,
                    facts.duration_s, facts.heatings, facts.heatings == 1 ? "heating" : "heatings");
  }
  text += fmt::format("{}: {}, {} {} in all; wire.toml is {}{}\n", name,
                      folder.is_new() ? "made" : "added to", folder.runs().size() + added.size(),
                      folder.runs().size() + added.size() == 1 ? "run" : "runs", preset,
                      card.number("wire.cold_resistance")
                          ? ""
                          : ", with its resistance, since the card does not know the wire's");
  return text + fmt::format("what others see: {}/{}\n", name, readme_name);
}

/// What the card and a run that is not wrong say differently.
void note_contradictions(const RunSource& source, const inspect::Facts& facts, const Card& card) {
  if (const std::string text = rate_note(facts, card); !text.empty()) {
    files::complain("host-sim", fmt::format("{}: {}", source.shown, text));
  }
  const bool has = std::ranges::any_of(facts.columns, [](const inspect::ColumnFacts& column) {
    return column.meaning == "displacement" || column.meaning == "strain_ref";
  });
  if (!has && card.word("displacement.sensor") != "none") {
    files::complain("host-sim",
                    fmt::format("{}: has no displacement and no strain_ref, and the card has a "
                                "sensor; if a column is it, --column displacement=NAME:mm says so",
                                source.shown));
  }
}

std::string add_runs(const RecordTask& task, const Card& card, Folder& folder) {
  const std::vector<std::string> names = names_of(task, folder);
  const files::WireDescription wire = wire_of(card);
  folder.begin();
  std::vector<RunFacts> added;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const RunSource& source = task.runs[i].source;
    added.emplace_back(names[i], take_run(source, card, wire, folder.staged_run(names[i])));
    note_contradictions(source, added.back().second, card);
  }
  stage_beginning(folder, card, wire);
  const std::string preset = preset_of(card);
  folder.stage(readme_name, readme_text(card, preset, all_facts(folder, wire, added)));
  folder.complete(names);
  return summary(folder, card, preset, added);
}

/// A file name that nothing has, beside the folder.
std::string rescue_path(const std::string& out, const std::string& name) {
  const std::string stem = (fs::path(out) / "").parent_path().string() + "-" + name;
  std::string path = stem + ".csv";
  std::error_code ignored;
  for (int number = 2; fs::exists(path, ignored); ++number) {
    path = fmt::format("{}-{}.csv", stem, number);
  }
  return path;
}

/// A message about the temporary file of a recording, as one about where it came from.
std::string renamed(std::string message, const std::string& path, const std::string& from) {
  for (std::size_t at = 0; !path.empty() && (at = message.find(path, at)) != std::string::npos;
       at += from.size()) {
    message.replace(at, path.size(), from);
  }
  return message;
}

}  // namespace

std::string record_runs(const RecordTask& task) {
  for (const NamedRun& run : task.runs) {
    check_allowed(run.source.allowed);
  }
  const Card card = load_card(task.card);  // may be a pipe, whose wait a signal is to end
  const EndBySignal guard;
  Folder folder(task.out, card);
  return add_runs(task, card, folder);
}

std::string record_bus(const BusTask& task, const std::function<Recorded()>& record) {
  check_allowed(task.allowed);
  const Card card = load_card(task.card);
  Folder folder(task.out, card);
  const std::string name = task.name.empty() ? folder.free_name() : task.name;
  folder.refuse_taken(name);
  // A signal during the recording ends the program at once: nothing has been written by then.
  const Recorded recorded = record();
  const EndBySignal guard;
  if (recorded.left_out > 0) {
    files::complain("host-sim", fmt::format("{}: {} rows have no reading of current, voltage or "
                                            "load and are left out",
                                            task.from, recorded.left_out));
  }
  std::string raw;
  try {
    const TemporaryFolder scratch;
    raw = (scratch / "recording.csv").string();
    files::OutputFile file(raw);
    file.write(recorded.csv);
    file.commit();
    RecordTask files_task{task.card, task.out, {{name, {}}}};
    files_task.runs[0].source.path = raw;
    files_task.runs[0].source.shown = task.from;
    files_task.runs[0].source.allowed = task.allowed;
    return add_runs(files_task, card, folder);
  } catch (const std::exception& error) {
    folder.abandon();  // before the guard ends the program
    const std::string kept = rescue_path(task.out, name);
    files::OutputFile file(kept);
    file.write(recorded.csv);
    file.commit();
    const std::string said =
        fmt::format("{}; the recording is kept as {}", renamed(error.what(), raw, task.from), kept);
    if (EndBySignal::came()) {
      files::complain("host-sim", said);  // the guard ends the program before others can
    }
    throw files::UserError(said);
  }
}

}  // namespace smaservo::record
