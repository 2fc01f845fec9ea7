#include "host-sim/replay/ci/outcome.hpp"

#include <algorithm>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::replay {
namespace {

bool has_errors(const Outcome& outcome) {
  return !outcome.errors.empty();
}

/// What is wrong with a trace that was replayed.
std::vector<std::string> failures(const Outcome& outcome) {
  std::vector<std::string> all = outcome.misses;
  if (!outcome.lost.empty()) {
    all.push_back(outcome.lost);
  }
  return all;
}

/// A text on one line as an attribute or content of XML 1.0. That forbids control characters, which
/// become escapes as on a terminal, and two symbols more.
std::string xml(const std::string& text) {
  std::string line = files::printable(text);
  for (const auto& [symbol, escape] :
       {std::pair{"\xEF\xBF\xBE", R"(\xEF\xBF\xBE)"}, {"\xEF\xBF\xBF", R"(\xEF\xBF\xBF)"}}) {
    for (std::size_t at = line.find(symbol); at != std::string::npos; at = line.find(symbol)) {
      line.replace(at, 3, escape);
    }
  }
  return files::escaped(line);
}

std::string property(const std::string& name, const std::string& value) {
  return fmt::format("    <property name=\"{}\" value=\"{}\"/>\n", xml(name), xml(value));
}

/// Properties are the suite's, since some readers refuse them in a case.
std::string properties(const Outcome& outcome) {
  if (!outcome.result) {
    return "";
  }
  const ReplayResult& result = *outcome.result;
  const std::string name = outcome.name();
  std::string text = property(name + ": rows", std::to_string(result.rows)) +
                     property(name + ": skipped rows", std::to_string(result.skipped)) +
                     property(name + ": invalid rows", std::to_string(result.invalid));
  for (const ObserverResult& observer : result.observers) {
    const ErrorStatistics& e = observer.error;
    if (e.count() > 0) {
      const std::string of = fmt::format("{}: {}: ", name, observer.name);
      text += property(of + "mean_percent", fmt::format("{:.4f}", e.mean())) +
              property(of + "p95_percent", fmt::format("{:.2f}", e.quantile(0.95))) +
              property(of + "max_percent", fmt::format("{:.4f}", e.maximum()));
    }
  }
  return text;
}

std::string problem(const char* element, const char* type, const std::vector<std::string>& lines) {
  std::string text = fmt::format(
      R"(    <{} message="{}" type="{}">)", element,
      xml(lines.size() == 1 ? lines.front()
                            : fmt::format("{}; and {} more", lines.front(), lines.size() - 1)),
      type);
  for (const std::string& line : lines) {
    text += (&line == &lines.front() ? "" : "\n") + xml(line);
  }
  return text + fmt::format("</{}>\n", element);
}

/// Some readers know one problem in a case, so an error has the failures' lines as well.
std::string test_case(const Outcome& outcome) {
  std::vector<std::string> lines = outcome.errors;
  std::ranges::copy(failures(outcome), std::back_inserter(lines));
  std::string text =
      fmt::format(R"(  <testcase classname="host-sim.replay" name="{}" time="{:.3f}")",
                  xml(outcome.name()), outcome.elapsed_s);
  if (lines.empty()) {
    return text + "/>\n";
  }
  text += ">\n";
  text += has_errors(outcome)       ? problem("error", "replay", lines)
          : !outcome.misses.empty() ? problem("failure", "bound", lines)
                                    : problem("failure", "lost", lines);
  return text + "  </testcase>\n";
}

std::string verdict(const Outcome& outcome) {
  const std::string failed = fmt::format("{}", fmt::join(failures(outcome), "; "));
  return has_errors(outcome) ? fmt::format("error: {}", fmt::join(outcome.errors, "; "))
         : !failed.empty()   ? "failed: " + failed
         : outcome.judged    ? "passed"
                             : "replayed";
}

/// The observer whose errors the summary shows: the one that writes the estimate.
const ErrorStatistics* shown(const Outcome& outcome) {
  return outcome.result && outcome.result->observers.front().error.count() > 0
             ? &outcome.result->observers.front().error
             : nullptr;
}

}  // namespace

void judge(Outcome& outcome, const ReplayResult& result, std::span<const Bounds> bounds) {
  for (const Bounds& b : bounds) {
    outcome.judged = true;
    try {
      for (std::string& miss : misses(b, result)) {
        // Two bounds on one value may be missed alike.
        if (std::ranges::find(outcome.misses, miss) == outcome.misses.end()) {
          outcome.misses.push_back(std::move(miss));
        }
      }
    } catch (const files::UserError& error) {
      outcome.errors.push_back(fmt::format("{}: {}", outcome.name(), error.what()));
    }
  }
}

int exit_status(std::span<const Outcome> outcomes) {
  const auto any = [&](const auto& is) { return std::ranges::any_of(outcomes, is); };
  return any([](const Outcome& o) { return has_errors(o) || !o.misses.empty(); }) ? 1
         : any([](const Outcome& o) { return !o.lost.empty(); })                  ? 3
                                                                                  : 0;
}

std::string junit_xml(std::span<const Outcome> outcomes,
                      std::chrono::system_clock::time_point began) {
  double elapsed_s = 0;
  std::string all_properties, cases;
  for (const Outcome& outcome : outcomes) {
    elapsed_s += outcome.elapsed_s;
    all_properties += properties(outcome);
    cases += test_case(outcome);
  }
  const auto errors = std::ranges::count_if(outcomes, has_errors);
  const auto failed = std::ranges::count_if(
      outcomes, [](const Outcome& o) { return !has_errors(o) && !failures(o).empty(); });
  const auto seconds = std::chrono::time_point_cast<std::chrono::seconds>(began);
  // The name of the machine is nobody's business; the schema's own default takes its place.
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<testsuite name=\"host-sim replay\" tests=\"{}\" failures=\"{}\" errors=\"{}\" "
      "skipped=\"0\" time=\"{:.3f}\" timestamp=\"{:%Y-%m-%dT%H:%M:%S}\" hostname=\"localhost\">\n"
      "  <properties>\n{}  </properties>\n{}  <system-out/>\n  <system-err/>\n</testsuite>\n",
      outcomes.size(), failed, errors, elapsed_s, fmt::gmtime(seconds), all_properties, cases);
}

std::string summary_markdown(std::span<const Outcome> outcomes) {
  files::TextTable table({{"trace"},
                          {"rows", "{}"},
                          {"mean", "{:.2f} %"},
                          {"95 %", "{:.2f} %"},
                          {"maximum", "{:.2f} %"},
                          {"verdict"}});
  for (const Outcome& outcome : outcomes) {
    files::TextTable::Row row{outcome.name(), {}, {}, {}, {}, {}};
    if (outcome.result) {
      row[1] = outcome.result->rows;
    }
    if (const ErrorStatistics* const error = shown(outcome)) {
      row[2] = error->mean();
      row[3] = error->quantile(0.95);
      row[4] = error->maximum();
    }
    row[5] = {verdict(outcome), has_errors(outcome) || !failures(outcome).empty()};
    table.add(std::move(row));
  }
  return table.markdown();
}

}  // namespace smaservo::replay
