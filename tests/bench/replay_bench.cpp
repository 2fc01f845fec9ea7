// Throughput of a replay with all columns written, beside a bare read of the same file; of traces
// as CSV and as MCAP, and how large they are.

#include <array>
#include <benchmark/benchmark.h>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <stdexcept>
#include <string>
#include <unistd.h>

#include "hal/recording/trace_file.hpp"
#include "hal/replay/trace.hpp"
#include "host-sim/replay/replay.hpp"
#include "model/wire/plant.hpp"
#include "tests/bench/main.hpp"

namespace smaservo::benchmarks {
namespace {

constexpr int rows = 1'000'000;
constexpr double ambient_K = room_K;

/// A folder for the trace and what is made of it, gone at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = std::filesystem::temp_directory_path() / "smaservo-bench-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) {
      throw std::runtime_error("cannot make a folder like " + pattern);
    }
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string file(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// The default wire at 1 kHz and 150 MPa, its power up and down within 20 s, with sensor noise.
void write_trace(const std::string& path, const Wire<double>& wire) {
  using Model = Plant<ThreePhase<double>>;
  const Model::Params params = plant_params(wire);
  constexpr double stress_Pa = 150e6;
  constexpr int half = 10'000;
  const double load_N = stress_Pa * wire.geometry.area_m2();
  const double max_W = params.body.loss_W(90);
  Model::State state = Model::rest(params, {ambient_K, stress_Pa});
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise;
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) {
    throw std::runtime_error("cannot write " + path);
  }
  std::fputs("time_s,current_A,voltage_V,load_N,strain_ref\n", file);
  for (int i = 0; i < rows; ++i) {
    const double share = static_cast<double>(std::abs(i % (2 * half) - half)) / half;
    const double power_W = max_W * (1 - 0.98 * share);
    const double ohm = Model::resistance_ohm(params, state, ambient_K);
    const double current_A = std::sqrt(power_W / ohm);
    std::fprintf(file, "%.3f,%.6f,%.5f,%.4f,%.6f\n", i * 1e-3, current_A,
                 current_A * ohm * (1 + 1e-4 * noise(random)), load_N,
                 Model::strain(params, state));
    Model::advance(params, state, {power_W, stress_Pa, ambient_K}, 1e-3);
  }
  if (std::fclose(file) != 0) {
    throw std::runtime_error("cannot write " + path);
  }
}

void time_replay(benchmark::State& state, const replay::ReplayOptions& options) {
  std::uint64_t bytes = 0;
  for ([[maybe_unused]] auto _ : state) {
    const replay::ReplayResult result = replay::replay(options);
    if (result.rows != rows) {
      state.SkipWithError("rows are missing");
    }
    bytes += result.bytes;
  }
  state.SetItemsProcessed(state.iterations() * rows);
  state.SetBytesProcessed(static_cast<std::int64_t>(bytes));
}

void time_read(benchmark::State& state, const std::string& path) {
  static std::array<char, std::size_t{1} << 16U> buffer;
  std::int64_t bytes = 0;
  for ([[maybe_unused]] auto _ : state) {
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) {
      state.SkipWithError("the trace is gone");
      break;
    }
    ssize_t got = 0;
    while ((got = read(file, buffer.data(), buffer.size())) > 0) {
      bytes += got;
    }
    close(file);
  }
  state.SetItemsProcessed(state.iterations() * rows);
  state.SetBytesProcessed(bytes);
}

/// The rows of the text as a file, in pieces as programs write them.
void time_writing(benchmark::State& state, const std::string& text, const std::string& path) {
  constexpr std::size_t piece = std::size_t{1} << 18U;
  for ([[maybe_unused]] auto _ : state) {
    hal::TraceFile file(path, {"bench", "bench"});
    for (std::size_t at = 0; at < text.size(); at += piece) {
      file.write(std::string_view(text).substr(at, piece));
    }
    file.commit();
  }
  state.SetItemsProcessed(state.iterations() * rows);
  state.counters["file_bytes"] = static_cast<double>(std::filesystem::file_size(path));
}

void time_reading(benchmark::State& state, const std::string& path) {
  for ([[maybe_unused]] auto _ : state) {
    hal::TraceReader reader(path, {});
    for (hal::TraceRow row; reader.next(row);) {
    }
    if (reader.rows() != rows) {
      state.SkipWithError("rows are missing");
    }
  }
  state.SetItemsProcessed(state.iterations() * rows);
}

}  // namespace

void register_benchmarks() {
  static const TemporaryFolder folder;
  replay::ReplayOptions options;
  options.trace = folder.file("trace.csv");
  options.wire = files::load_wire(std::string(files::default_wire));
  options.out = folder.file("estimate.csv");
  write_trace(options.trace, options.wire.wire);
  const auto add = [](const char* name, auto function) {
    benchmark::RegisterBenchmark(name, function)->Unit(benchmark::kMillisecond)->UseRealTime();
  };
  for (const char* observer : {"kalman", "line"}) {
    options.observers = {observer};
    add((std::string("replay/") + observer).c_str(),
        [options](benchmark::State& state) { time_replay(state, options); });
  }
  std::ifstream in(options.trace, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  for (const char* kind : {"csv", "mcap"}) {
    const std::string path = folder.file("written.") + kind;
    add((std::string("write/") + kind).c_str(),
        [text, path](benchmark::State& state) { time_writing(state, text, path); });
    add((std::string("read/") + kind).c_str(),
        [path](benchmark::State& state) { time_reading(state, path); });
  }
  options.observers = {"kalman"};
  options.out = folder.file("estimate.mcap");
  add("replay/mcap", [options](benchmark::State& state) { time_replay(state, options); });
  add("bare_read", [path = options.trace](benchmark::State& state) { time_read(state, path); });
}

}  // namespace smaservo::benchmarks
