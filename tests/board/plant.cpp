// The wire of a closed loop in a guest: what gets through testboard's drive heats it, its readings
// become codes of testboard's ADC. Things happen at their times, and it says when the heat ended.
//
//   plant SCENARIO SECONDS [TIME PATH VALUE]...
//
// At TIME it writes VALUE to PATH, or, where PATH is pid:FILE, sends the signal VALUE to the
// process that FILE names. Time is CLOCK_MONOTONIC's, from the program's start.

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <fcntl.h>
#include <fstream>
#include <sched.h>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <vector>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "hal/sim/board.hpp"
#include "model/units.hpp"
#include "testboard.hpp"

namespace smaservo {
namespace {

constexpr std::int64_t step_ns = 1'000'000;
constexpr std::int64_t second_ns = 1'000'000'000;

struct Happening {
  double time_s;
  std::string path, value;
};

std::int64_t clock_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * second_ns + now.tv_nsec;
}

void sleep_until(std::int64_t time_ns) {
  const timespec until{time_ns / second_ns, time_ns % second_ns};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) != 0) {
  }
}

void make_happen(const Happening& happening) {
  constexpr std::string_view process = "pid:";
  if (happening.path.starts_with(process)) {
    pid_t id = 0;
    std::ifstream(happening.path.substr(process.size())) >> id;
    if (id <= 0 || kill(id, std::stoi(happening.value)) != 0) {
      throw std::runtime_error("no process: " + happening.path);
    }
    return;
  }
  std::ofstream file(happening.path);
  file << happening.value << std::flush;
  if (!file) {
    throw std::runtime_error("cannot write: " + happening.path);
  }
}

/// What it looked like in the last half second.
class Tail {
 public:
  void add(double strain) {
    recent_.push_back(strain);
    if (recent_.size() > 500) {
      recent_.erase(recent_.begin());
    }
  }
  double mean() const {
    double sum = 0;
    for (const double strain : recent_) {
      sum += strain;
    }
    return sum / static_cast<double>(recent_.size());
  }
  double span() const {
    const auto [low, high] = std::ranges::minmax_element(recent_);
    return *high - *low;
  }

 private:
  std::vector<double> recent_;
};

class Plant {
 public:
  /// Its drive chops the supply.
  explicit Plant(const bench::ClosedLoopScenario& scenario)
      : file_(open("/dev/testboard", O_RDWR | O_CLOEXEC)),
        board_(bench::make_plant(scenario.plant), scenario.board),
        ambient_K_(scenario.board.surroundings.ambient_K),
        supply_V_(scenario.board.surroundings.supply_V) {
    if (file_ < 0) {
      throw std::runtime_error("no /dev/testboard");
    }
  }
  ~Plant() { close(file_); }
  Plant(const Plant&) = delete;
  Plant& operator=(const Plant&) = delete;

  /// One millisecond of the wire.
  void step() {
    if (read(file_, &output_, sizeof output_) != sizeof output_) {
      throw std::runtime_error("cannot read /dev/testboard");
    }
    const double duty = output_.period_ns == 0 ? 0
                                               : static_cast<double>(output_.effective_ns) /
                                                     static_cast<double>(output_.period_ns);
    board_.drive({0, duty * supply_V_, board_.now_ns() + 2 * step_ns});
    hal::Frame frame{};
    if (board_.read(frame) == hal::ReadStatus::frame) {
      give(frame);
    }
    const hal::SimTruth truth = board_.truth();
    hottest_K_ = std::max(hottest_K_, truth.hottest_K);
    tail_.add(truth.strain);
  }

  const BoardOutput& output() const { return output_; }
  void print() const {
    std::printf("PLANT strain_percent=%.4f span_percent=%.4f hottest_degC=%.1f cuts=%llu\n",
                100 * tail_.mean(), 100 * tail_.span(), hottest_K_ - zero_degC_K,
                static_cast<unsigned long long>(output_.cuts));
  }

 private:
  void give(const hal::Frame& frame) const {
    using namespace board_channels;
    const BoardCodes codes{{current.code(frame.current_A), voltage.code(frame.voltage_V),
                            load.code(frame.load_N), supply.code(frame.supply_V),
                            ambient.code(ambient_K_), driver.code(frame.driver_K), 0, 0}};
    if (write(file_, &codes, sizeof codes) != sizeof codes) {
      throw std::runtime_error("cannot write /dev/testboard");
    }
  }

  int file_;
  hal::SimBoard board_;
  double ambient_K_, supply_V_;
  BoardOutput output_{};
  double hottest_K_ = 0;
  Tail tail_;
};

/// Says what has happened, and how long after it the heat ended.
class Watch {
 public:
  void happened(const Happening& happening, std::int64_t time_ns, bool heated) {
    what_ = happening.path + " " + happening.value;
    since_ns_ = time_ns;
    pending_ = heated;
    std::printf("HAPPENED %.3f %s%s\n", happening.time_s, what_.c_str(),
                heated ? "" : " (without heat)");
  }
  void look(const BoardOutput& output) {
    const auto changed_ns = static_cast<std::int64_t>(output.changed_ns);
    if (!pending_ || output.effective_ns != 0 || changed_ns < since_ns_) {
      return;
    }
    std::printf("OFF after_us=%.1f by=%s: %s\n", static_cast<double>(changed_ns - since_ns_) * 1e-3,
                output.cuts == cuts_ ? "program" : "one-shot", what_.c_str());
    pending_ = false;
  }
  void count(const BoardOutput& output) {
    if (!pending_) {
      cuts_ = output.cuts;
    }
  }
  void end() const {
    if (pending_) {
      std::printf("HOT %s\n", what_.c_str());
    }
  }

 private:
  std::string what_;
  std::int64_t since_ns_ = 0;
  bool pending_ = false;
  std::uint64_t cuts_ = 0;
};

int simulate(const std::vector<std::string>& arguments) {
  const bench::ClosedLoopScenario scenario = bench::load_closed_loop(arguments.at(0));
  const double seconds = std::stod(arguments.at(1));
  std::vector<Happening> happenings;
  for (std::size_t i = 2; i + 2 < arguments.size(); i += 3) {
    happenings.push_back({std::stod(arguments[i]), arguments[i + 1], arguments[i + 2]});
  }
  Plant plant(scenario);
  Watch watch;
  const sched_param priority{.sched_priority = 10};
  sched_setscheduler(0, SCHED_FIFO, &priority);
  const std::int64_t begin_ns = clock_ns();
  const auto steps = static_cast<std::int64_t>(seconds * 1e9) / step_ns;
  std::size_t next = 0;
  for (std::int64_t i = 0; i < steps; ++i) {
    sleep_until(begin_ns + i * step_ns);
    plant.step();
    if (i == 0) {
      std::puts("READY");
    }
    watch.count(plant.output());
    watch.look(plant.output());
    if (next < happenings.size() &&
        static_cast<double>(i * step_ns) * 1e-9 >= happenings[next].time_s) {
      const std::int64_t now_ns = clock_ns();
      make_happen(happenings[next]);
      watch.happened(happenings[next++], now_ns, plant.output().effective_ns != 0);
    }
  }
  watch.end();
  plant.print();
  return 0;
}

}  // namespace
}  // namespace smaservo

int main(int argc, char** argv) {
  try {
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
    return smaservo::simulate(std::vector<std::string>(argv + 1, argv + argc));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "plant: %s\n", error.what());
    return 1;
  }
}
