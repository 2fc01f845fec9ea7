// Writes what the microcontrollers replay: every shipped trace as the device sees it when it only
// watches, every shipped closed loop, one of them with a wire of another kind, and random use.
// answer_steps says what should come out.
//   write_steps FOLDER

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "firmware/bench/closed_loop.hpp"
#include "firmware/bench/scenario/scenario.hpp"
#include "firmware/cycle.hpp"
#include "firmware/text/settings_file.hpp"
#include "hal/replay/board.hpp"
#include "model/files/error.hpp"
#include "tests/firmware/device/random_use.hpp"
#include "tests/firmware/parameters/random_settings.hpp"
#include "tests/mcu/step_file.hpp"
#include "tests/model/wire/ordered_wire.hpp"
#include "tests/places.hpp"

namespace smaservo::mcu {
namespace {

namespace fs = std::filesystem;

/// Steps on this machine, and their file.
class Recorder {
 public:
  explicit Recorder(const Settings<float>& settings) : settings_(settings) {}

  const Output<float>& add(const StepInputs& inputs) {
    records_.push_back({inputs, step(prepared_, state_, inputs)});
    return state_.last;
  }
  bool empty() const { return records_.empty(); }

  void write(const fs::path& path) const {
    std::vector<std::byte> image;
    image::write(own_schema<float>, settings_, 1, [&](std::span<const std::byte> chunk) {
      image.insert(image.end(), chunk.begin(), chunk.end());
      return true;
    });
    const StepFileHeader header{StepFileHeader::own_magic,
                                static_cast<std::uint32_t>(image.size()),
                                static_cast<std::uint32_t>(records_.size()),
                                {}};
    std::ofstream file(path, std::ios::binary);
    const auto put = [&](std::span<const std::byte> bytes) {
      file.write(reinterpret_cast<const char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size()));
    };
    put(std::as_bytes(std::span(&header, 1)));
    put(image);
    put(std::as_bytes(std::span(records_)));
    if (!file.flush()) {
      throw files::UserError(path.string() + ": cannot be written");
    }
  }

 private:
  Settings<float> settings_;
  Prepared<float> prepared_ = prepare(settings_);
  Device<float>::State state_ = Device<float>::start();
  std::vector<StepRecord> records_;
};

/// The device watches: it is never armed.
Recorder trace(const fs::path& scenario, hal::TraceReader reader) {
  const Settings<double> settings = text::settings_for(bench::load_scenario(scenario).wire.wire);
  Recorder recorder(stored_settings<float>(settings));
  hal::ReplayBoard board(std::move(reader), 0, settings.wire.geometry.area_m2());
  hal::Frame frame{};
  std::int64_t last_ns = 0;
  for (hal::ReadStatus status = board.read(frame); status != hal::ReadStatus::end;
       status = board.read(frame)) {
    const std::int64_t step_ns =
        std::clamp(frame.time_ns - last_ns, shortest_step_ns, longest_step_ns);
    last_ns = frame.time_ns;
    Command<float> command;
    command.fresh = true;
    recorder.add(pack(smaservo::inputs_of<float>(frame, status), command,
                      1e-9F * static_cast<float>(step_ns), recorder.empty()));
  }
  return recorder;
}

Recorder closed_loop(const bench::ClosedLoopScenario& scenario) {
  Recorder recorder(stored_settings<float>(scenario.settings));
  bench::ClosedLoop loop(scenario);
  double last_s = -scenario.settings.timing.period_s;
  while (loop.step()) {
    const bench::SimulatedCycle& cycle = loop.cycle();
    recorder.add(pack(cycle.inputs, cycle.command, cycle.time_s - last_s, recorder.empty()));
    last_s = cycle.time_s;
  }
  return recorder;
}

/// The scenario with a wire that is calibrated as one of another kind than paper 000's.
bench::ClosedLoopScenario with_ordered_wire(bench::ClosedLoopScenario scenario) {
  scenario.settings.wire.kinetics = test::ordered_wire().kinetics;
  scenario.plant.wire.wire.kinetics = test::ordered_wire().kinetics;
  return scenario;
}

/// Bounds the gain so that the last bit of the controlled variable, in which two maths libraries
/// differ, asks for no more than a millionth of a watt.
void tame(LoopGains<float>& gains, float last_bit) {
  const float lead = gains.derivative_s / std::max(gains.derivative_filter_s, 1e-3F);
  gains.proportional = std::min(gains.proportional, 1e-6F / (last_bit * (1 + lead)));
}

/// Random settings and a device that is closed on its own wire, in every trouble there is.
Recorder random_use(std::uint32_t seed, std::size_t steps) {
  std::mt19937 random(seed);
  const Settings<float> usual = test_settings<float>();
  Settings<float> settings = random_settings<float>(random);
  settings.wire = usual.wire;
  settings.measurement = usual.measurement;
  settings.trips = usual.trips;
  tame(settings.strain, 3.7e-9F);
  tame(settings.temperature, 3.1e-5F);
  tame(settings.resistance, 1.9e-6F);
  tame(settings.force, 1.2e-7F);
  Recorder recorder(stored_settings<float>(settings));
  RandomUse<float> use(seed);
  Output<float> last{};
  bool starts = true;
  for (std::size_t i = 0; i < steps; ++i) {
    use.next(last);
    last = recorder.add(pack(use.inputs, use.command, use.dt_s, starts));
    starts = use.idle();
    if (starts) {
      use.rest();
      last = {};
    }
  }
  return recorder;
}

void write_all(const fs::path& folder) {
  const fs::path root = test::source_folder();
  fs::create_directories(folder);
  for (const fs::directory_entry& entry : fs::directory_iterator(root / "host-sim/traces")) {
    fs::path csv = entry.path();
    if (csv.extension() != ".toml" || !fs::exists(csv.replace_extension(".csv"))) {
      continue;
    }
    hal::TraceReader reader(csv.string(), {});
    if (reader.has(hal::Column::voltage)) {  // a bath has neither voltage nor current
      trace(entry.path(), std::move(reader))
          .write(folder / fmt::format("trace-{}.steps", csv.stem().string()));
    }
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(root / "host-sim/scenarios")) {
    if (entry.path().extension() == ".toml") {
      closed_loop(bench::load_closed_loop(entry.path()))
          .write(folder / fmt::format("loop-{}.steps", entry.path().stem().string()));
    }
  }
  closed_loop(
      with_ordered_wire(bench::load_closed_loop(root / "host-sim/scenarios/wire-break.toml")))
      .write(folder / "ordered-wire-break.steps");
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    random_use(seed, 10000).write(folder / fmt::format("random-{}.steps", seed));
  }
}

}  // namespace
}  // namespace smaservo::mcu

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: write_steps FOLDER\n", stderr);
    return 2;
  }
  try {
    smaservo::mcu::write_all(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "write_steps: %s\n", error.what());
    return 1;
  }
  return 0;
}
