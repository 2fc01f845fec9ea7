// A simulated wire and a CANopen master at the other end of an emulated board's pipes:
//   hold_strain FOLDER QEMU ARGUMENT...
// Starts the board in FOLDER, enables its drive, moves it by frames and judges what the wire does.

#include <array>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <span>
#include <spawn.h>
#include <string>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "firmware/parameters/store/store_image.hpp"
#include "hal/cortex-m/wire_link.hpp"
#include "model/files/error.hpp"
#include "tests/places.hpp"

namespace smaservo::mcu {
namespace {

namespace fs = std::filesystem;
namespace link = cortex_m::link;

constexpr std::int64_t one_shot_ns = 5'000'000;
constexpr int steps = 4000;

class Pipe {
 public:
  /// Opened for both directions, so that neither end waits for the other to open.
  explicit Pipe(const fs::path& path) {
    fs::remove(path);
    if (::mkfifo(path.c_str(), 0600) != 0) {
      throw files::UserError(path.string() + ": no named pipe can be made");
    }
    file_ = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  }
  ~Pipe() { ::close(file_); }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  Pipe(Pipe&&) = delete;
  Pipe& operator=(Pipe&&) = delete;

  template <class T>
  void put(const T& record) const {
    if (::write(file_, &record, sizeof record) != ssize_t{sizeof record}) {
      throw files::UserError("a pipe does not take what is written");
    }
  }
  template <class T>
  T get() const {
    T record{};
    if (::read(file_, &record, sizeof record) != ssize_t{sizeof record}) {
      throw files::UserError("the board has gone");
    }
    return record;
  }
  int file() const { return file_; }

 private:
  int file_ = -1;
};

/// The emulator; what is left of it ends with this.
class Board {
 public:
  Board(const fs::path& folder, std::span<char* const> command) {
    fs::current_path(folder);
    std::vector<char*> arguments(command.begin(), command.end());
    arguments.push_back(nullptr);
    if (::posix_spawnp(&process_, arguments[0], nullptr, nullptr, arguments.data(), environ) != 0) {
      throw files::UserError(fmt::format("{} cannot be started", arguments[0]));
    }
  }
  ~Board() {
    if (process_ > 0) {
      ::kill(process_, SIGKILL);
      ::waitpid(process_, nullptr, 0);
    }
  }
  Board(const Board&) = delete;
  Board& operator=(const Board&) = delete;
  Board(Board&&) = delete;
  Board& operator=(Board&&) = delete;

 private:
  pid_t process_ = -1;
};

/// What a PLC would do: start, enable, go somewhere.
class Master {
 public:
  explicit Master(std::int32_t target_um) : target_um_(target_um) {}

  /// Frames of this period.
  std::vector<hal::CanFrame> frames(int period) {
    switch (period) {
      case 300:
        return {{.id = 0, .length = 2, .data = {1, 1}}};
      case 310:
        return {control(0x06)};
      case 320:
        return {control(0x07)};
      case 330:
        return {control(0x0F)};
      case 800:
        return {target(), control(0x3F)};
      default:
        return {};
    }
  }
  void heard(const hal::CanFrame& frame) {
    if (frame.id == 0x181) {
      status = static_cast<std::uint16_t>(frame.data[0] | frame.data[1] << 8);
    }
    emergencies += frame.id == 0x081 ? 1 : 0;
    ++heard_frames;
  }
  bool is_enabled() const { return (status & 0x6FU) == 0x27; }

  std::uint16_t status = 0;
  int emergencies = 0, heard_frames = 0;

 private:
  static hal::CanFrame control(std::uint8_t word) {
    return {.id = 0x201, .length = 3, .data = {word, 0, 1}};
  }
  hal::CanFrame target() const {
    const auto bits = static_cast<std::uint32_t>(target_um_);
    hal::CanFrame frame{.id = 0x301, .length = 8};
    for (unsigned i = 0; i < 4; ++i) {
      frame.data.at(i) = static_cast<std::uint8_t>(bits >> 8U * i);
    }
    return frame;
  }

  std::int32_t target_um_;
};

/// The board's converter and output stage, with the wire behind them.
class Bench {
 public:
  explicit Bench(const bench::ClosedLoopScenario& scenario)
      : board_(bench::make_plant(scenario.plant), scenario.board) {}

  void drive(const link::Drive& drive) {
    if (drive.kicked != 0) {
      kicked_until_ns_ = board_.now_ns() + one_shot_ns;
    }
    const std::int64_t until_ns =
        std::min(kicked_until_ns_, board_.now_ns() + std::int64_t{drive.lease_us} * 1000);
    board_.drive(
        {static_cast<double>(drive.current_A), static_cast<double>(drive.voltage_V), until_ns});
  }
  link::Readings read() {
    hal::Frame frame{};
    const hal::ReadStatus status = board_.read(frame);
    const auto f = [](double x) { return static_cast<float>(x); };
    return {frame.sequence,     status == hal::ReadStatus::frame ? link::fresh : 0U,
            f(frame.current_A), f(frame.voltage_V),
            f(frame.load_N),    f(frame.supply_V),
            f(frame.ambient_K), f(frame.driver_K)};
  }
  hal::SimTruth truth() const { return board_.truth(); }

 private:
  hal::SimBoard board_;
  std::int64_t kicked_until_ns_ = 0;
};

class Run {
 public:
  Run(const fs::path& folder, const bench::ClosedLoopScenario& scenario)
      : settings_(scenario.settings),
        bench_(scenario),
        drive_(folder / "drive"),
        readings_(folder / "readings"),
        can_out_(folder / "can-out"),
        can_in_(folder / "can-in"),
        start_strain_(bench_.truth().strain),
        target_(start_strain_ - 0.5 * settings_.wire.nominal_stroke),
        master_(static_cast<std::int32_t>(std::lround((settings_.axis.zero_strain - target_) *
                                                      settings_.wire.geometry.length_m * 1e6))) {}

  void go() {
    for (int period = 0; period < steps; ++period) {
      bench_.drive(drive_.get<link::Drive>());
      readings_.put(bench_.read());
      talk(period);
      judge(period);
    }
  }
  bool passed() const {
    const double stroke = settings_.wire.nominal_stroke;
    std::printf(
        "%d frames heard, %d emergencies, statusword %04x; heated before enabled: %s; strain %.2f "
        "%% "
        "to %.2f %%, worst error of the last second %.2f %% of the stroke\n",
        master_.heard_frames, master_.emergencies, master_.status, early_heat_ ? "yes" : "no",
        100 * start_strain_, 100 * bench_.truth().strain, 100 * worst_ / stroke);
    return master_.is_enabled() && master_.emergencies == 0 && !early_heat_ &&
           worst_ < 0.01 * stroke;
  }

 private:
  /// One question per period, and one more for each frame that has been given.
  void talk(int period) {
    std::vector<hal::CanFrame> frames = master_.frames(period);
    std::size_t given = 0;
    for (bool asked = false; !asked;) {
      const auto said = can_out_.get<link::Can>();
      if (said.frames != 0) {
        master_.heard({.id = said.id, .length = said.length, .data = said.data});
      } else if (given < frames.size()) {
        const hal::CanFrame& f = frames[given++];
        can_in_.put(link::Can{1, f.id, f.length, {}, f.data});
      } else {
        can_in_.put(link::Can{});
        asked = true;
      }
    }
  }
  void judge(int period) {
    const hal::SimTruth truth = bench_.truth();
    early_heat_ = early_heat_ || (period < 330 && truth.current_A > 0);
    if (period >= steps - 1000) {
      worst_ = std::max(worst_, std::abs(truth.strain - target_));
    }
  }

  Settings<double> settings_;
  Bench bench_;
  Pipe drive_, readings_, can_out_, can_in_;
  double start_strain_, target_;
  Master master_;
  double worst_ = 0;
  bool early_heat_ = false;
};

void write_slot(const fs::path& path, const Settings<double>& settings) {
  std::ofstream file(path, std::ios::binary);
  image::write(own_schema<float>, stored_settings<float>(settings), 1,
               [&](std::span<const std::byte> chunk) {
                 file.write(reinterpret_cast<const char*>(chunk.data()),
                            static_cast<std::streamsize>(chunk.size()));
                 return file.good();
               });
}

bool hold(const fs::path& folder, std::span<char* const> command) {
  fs::create_directories(folder);
  const bench::ClosedLoopScenario scenario =
      bench::load_closed_loop(fs::path(test::source_folder()) / "host-sim/scenarios/steps.toml");
  write_slot(folder / "slot-0", scenario.settings);
  fs::remove(folder / "slot-1");
  Run run(folder, scenario);
  const Board board(folder, command);
  run.go();
  return run.passed();
}

}  // namespace
}  // namespace smaservo::mcu

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fputs("usage: hold_strain FOLDER QEMU ARGUMENT...\n", stderr);
    return 2;
  }
  try {
    const std::span<char* const> arguments(argv, static_cast<std::size_t>(argc));
    return smaservo::mcu::hold(std::filesystem::absolute(argv[1]), arguments.subspan(2)) ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hold_strain: %s\n", error.what());
    return 1;
  }
}
