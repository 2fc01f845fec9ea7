// Runs the checks, then replays step files beside what a PC has made of them.

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "hal/cortex-m/start_up.hpp"
#include "tests/mcu/checks.hpp"
#include "tests/mcu/printing.hpp"
#include "tests/mcu/step_reader.hpp"

namespace smaservo::mcu {
namespace {

using S = float;

// Of each number's range in its file.
constexpr float strain_tolerance = 1e-5F;
constexpr float tolerance = 1e-4F;

std::optional<StepReader> reader;
Prepared<S> prepared;
Device<S>::State state;

/// How many steps of each file, and the files.
struct Arguments {
  std::uint32_t max_steps = 0;
  std::string_view files;
};
Arguments arguments(std::string_view line) {
  Arguments all;
  const auto end = std::from_chars(line.data(), line.data() + line.size(), all.max_steps).ptr;
  all.files = line.substr(static_cast<std::size_t>(end - line.data()));
  return all;
}

bool run_checks(const Settings<S>& settings) {
  bool all = true;
  for (const Check& check : checks()) {
    Verdict verdict;
    check.run(settings, verdict);
    const bool passed = verdict.broken.empty();
    say(passed ? "passed " : "FAILED ", check.name, passed ? "" : ": ", verdict.broken, "\n");
    all = all && passed;
  }
  return all;
}

struct Comparison {
  float worst = 0, worst_strain = 0;
  std::uint32_t differing = 0;

  void add(const StepOutputs& here, const StepOutputs& there, const Ranges& ranges) {
    const auto a = std::bit_cast<StepNumbers>(here), b = std::bit_cast<StepNumbers>(there);
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const bool both_none = std::isnan(a.number[i]) && std::isnan(b.number[i]);
      const float error = both_none ? 0 : std::abs(a.number[i] - b.number[i]) / ranges[i];
      worst = error <= worst ? worst : error;
      worst_strain = i == StepNumbers::strain ? std::max(worst_strain, error) : worst_strain;
    }
    differing += a.words == b.words ? 0U : 1U;
  }
  bool agrees() const {
    return worst_strain <= strain_tolerance && worst <= tolerance && differing == 0;
  }
};

bool replay(std::string_view name, std::uint32_t max_steps) {
  reader.emplace(name);
  const auto settings = reader->settings<S>();
  if (!settings) {
    say("FAILED ", name, ": no settings\n");
    return false;
  }
  static bool checked = false;
  const bool checks_passed = checked || run_checks(*settings);
  checked = true;
  prepared = prepare(*settings);
  Comparison comparison;
  std::uint32_t steps = 0;
  for (const StepRecord* r = reader->next(); r != nullptr && steps < max_steps;
       r = reader->next(), ++steps) {
    comparison.add(step(prepared, state, r->inputs), r->outputs, reader->ranges());
  }
  const bool passed = comparison.agrees() && steps > 0;
  say(passed ? "passed " : "FAILED ", name, ": ", steps, " steps, numbers differ by ",
      comparison.worst, " of their range, the strain by ", comparison.worst_strain,
      "; other states or faults in ", comparison.differing, "\n");
  return passed && checks_passed;
}

bool replay_all(const Arguments& all) {
  std::string_view names = all.files;
  bool passed = false, failed = false;
  while (!names.empty()) {
    names.remove_prefix(std::min(names.find_first_not_of(' '), names.size()));
    const std::size_t size = std::min(names.find(' '), names.size());
    std::array<char, 256> name{};
    names.copy(name.data(), std::min(size, name.size() - 1));
    if (size > 0) {
      const bool one = replay(std::string_view(name.data(), size), all.max_steps);
      passed = passed || one;
      failed = failed || !one;
    }
    names.remove_prefix(size);
  }
  return passed && !failed;
}

}  // namespace
}  // namespace smaservo::mcu

int application() {
  using namespace smaservo;
  static std::array<char, 4096> line{};
  return mcu::replay_all(mcu::arguments(semihosting::arguments(line))) ? 0 : 1;
}
