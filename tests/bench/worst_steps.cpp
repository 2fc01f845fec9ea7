// The cost of each single step of the device in random use:
//   worst_steps FILE         times 10 million, prints their histogram, writes the costliest to FILE
//   worst_steps count FILE   runs those of FILE once more, each inside counted_step(), for
//   callgrind

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/firmware/device/random_use.hpp"
#include "tests/firmware/parameters/random_settings.hpp"

namespace smaservo::benchmarks {
namespace {

constexpr std::size_t all_steps = 10'000'000;
constexpr std::size_t session_steps = 20'000;
constexpr std::size_t kept_steps = 1000;

using S = double;

/// All that a step needs to be repeated.
struct Moment {
  Device<S>::State before;
  Inputs<S> inputs;
  Command<S> command;
  S dt_s;
  std::uint32_t session;
  std::uint32_t cost_ns;
};

bool cheaper(const Moment& a, const Moment& b) {
  return a.cost_ns > b.cost_ns;  // the cheapest is then at the top of the heap
}

/// Every session has other settings, for the same wire and sensors.
Prepared<S> session_settings(std::uint32_t session) {
  std::mt19937 random(session);
  const Settings<S> usual = test_settings<S>();
  Settings<S> settings = random_settings(random);
  settings.wire = usual.wire;
  settings.measurement = usual.measurement;
  settings.trips = usual.trips;
  return prepare(settings);
}

/// Out of line, as a board's loop would call it.
[[gnu::noinline]] void one_step(const Prepared<S>& p, Device<S>::State& s, const Moment& now) {
  Device<S>::step(p, s, now.inputs, now.command, now.dt_s);
  asm volatile("" : : "r"(&s) : "memory");
}

template <class F>
std::uint32_t time_ns(F f) {
  using Clock = std::chrono::steady_clock;
  const auto before = Clock::now();
  f();
  const auto after = Clock::now();
  return static_cast<std::uint32_t>(std::chrono::nanoseconds(after - before).count());
}

/// What reading the clock twice costs.
std::uint32_t clock_ns() {
  std::vector<std::uint32_t> all(100001);
  for (std::uint32_t& ns : all) {
    ns = time_ns([] {});
  }
  const auto middle = all.begin() + 50000;
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

class Search {
 public:
  void run() {
    costs.reserve(all_steps);
    for (std::uint32_t session = 0; costs.size() < all_steps; ++session) {
      run_session(session);
    }
  }

  std::vector<std::uint32_t> costs;
  std::vector<Moment> costliest;  ///< a heap; of a device that was observing
  std::map<DeviceState, std::size_t> states;
  std::vector<std::uint32_t> starts;  ///< costs of those that start the observer

 private:
  void run_session(std::uint32_t session) {
    const Prepared<S> prepared = session_settings(session);
    RandomUse<S> use(session);
    Device<S>::State state = Device<S>::start();
    Moment now{};
    now.session = session;
    for (std::size_t i = 0; i < session_steps; ++i) {
      use.next(state.last);
      now.before = state;
      now.inputs = use.inputs;
      now.command = use.command;
      now.dt_s = use.dt_s;
      now.cost_ns = cost(prepared, state, now);
      costs.push_back(now.cost_ns);
      ++states[state.last.state];
      if (now.before.observing) {
        keep(now);
      } else if (state.observing) {
        starts.push_back(now.cost_ns);
      }
      if (use.idle()) {
        state = Device<S>::start();
        use.rest();
      }
    }
  }
  /// What interrupts the program is not the step's: what is among the costliest is repeated, and
  /// the least of it counts.
  std::uint32_t cost(const Prepared<S>& prepared, Device<S>::State& state, const Moment& now) {
    std::uint32_t min = time_ns([&] { one_step(prepared, state, now); });
    for (int i = 0; i < 5 && is_costly(min); ++i) {
      Device<S>::State again = now.before;
      min = std::min(min, time_ns([&] { one_step(prepared, again, now); }));
    }
    return min < clock_ns_ ? 0 : min - clock_ns_;
  }
  bool is_costly(std::uint32_t ns) const {
    return costliest.size() < kept_steps || costliest.front().cost_ns + clock_ns_ < ns;
  }
  void keep(const Moment& now) {
    if (costliest.size() < kept_steps || costliest.front().cost_ns < now.cost_ns) {
      costliest.push_back(now);
      std::ranges::push_heap(costliest, cheaper);
    }
    if (costliest.size() > kept_steps) {
      std::ranges::pop_heap(costliest, cheaper);
      costliest.pop_back();
    }
  }

  std::uint32_t clock_ns_ = clock_ns();
};

void print_histogram(const std::vector<std::uint32_t>& sorted) {
  constexpr std::size_t widest = 50;
  std::puts("\n| ns from | to | steps | |\n|--:|--:|--:|---|");
  const auto below = [&](double ns) {
    const auto at = std::ranges::lower_bound(sorted, static_cast<std::uint32_t>(std::ceil(ns)));
    return static_cast<std::size_t>(at - sorted.begin());
  };
  const double first = std::floor(2 * std::log2(std::max(1U, sorted.front())));
  for (double i = first; below(std::exp2(i / 2)) < sorted.size(); ++i) {
    const double from = std::exp2(i / 2), to = std::exp2((i + 1) / 2);
    const std::size_t steps = below(to) - below(from);
    // A mark for each factor: one step of ten million would not be seen in a share.
    const double share = std::log2(1 + static_cast<double>(steps)) /
                         std::log2(1 + static_cast<double>(sorted.size()));
    const auto marks = static_cast<std::size_t>(std::ceil(share * widest));
    std::printf("| %.0f | %.0f | %zu | %s |\n", from, to, steps, std::string(marks, '#').c_str());
  }
}

void print(Search& search) {
  std::vector<std::uint32_t>& costs = search.costs;
  std::ranges::sort(costs);
  const auto quantile = [&](double share) {
    return costs[static_cast<std::size_t>(share * static_cast<double>(costs.size() - 1))];
  };
  double sum = 0;
  for (const std::uint32_t ns : costs) {
    sum += ns;
  }
  std::printf(
      "| %zu random steps of the device, double | mean | median | 99 %% | 99.99 %% | most |\n",
      costs.size());
  std::puts("|---|--:|--:|--:|--:|--:|");
  std::printf("| time of one step, ns | %.0f | %u | %u | %u | %u |\n",
              sum / static_cast<double>(costs.size()), quantile(0.5), quantile(0.99),
              quantile(0.9999), costs.back());
  print_histogram(costs);
  std::printf("\nStates: starting, ready, arming, running, stopping, fault:");
  for (std::uint8_t i = 0; i < device_state_count; ++i) {
    const auto steps = static_cast<double>(search.states[static_cast<DeviceState>(i)]);
    std::printf(" %.1f %%", 100 * steps / static_cast<double>(costs.size()));
  }
  std::vector<std::uint32_t>& starts = search.starts;
  std::ranges::sort(starts);
  std::printf("\nFirst samples, which start the observer: %zu, median %u ns\n", starts.size(),
              starts[starts.size() / 2]);
}

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

bool write(const char* path, const std::vector<Moment>& moments) {
  const File file(std::fopen(path, "wb"));
  return file &&
         std::fwrite(moments.data(), sizeof(Moment), moments.size(), file.get()) == moments.size();
}

std::vector<Moment> read(const char* path) {
  std::vector<Moment> moments(kept_steps);
  const File file(std::fopen(path, "rb"));
  moments.resize(file ? std::fread(moments.data(), sizeof(Moment), moments.size(), file.get()) : 0);
  return moments;
}

}  // namespace

/// Its name is what callgrind looks for.
extern "C" [[gnu::noinline]] void counted_step(const Prepared<S>& p, Device<S>::State& s,
                                               const Moment& now) {
  one_step(p, s, now);
}

}  // namespace smaservo::benchmarks

int main(int argc, char** argv) {
  using namespace smaservo::benchmarks;
  if (argc == 2) {
    Search search;
    search.run();
    print(search);
    return write(argv[1], search.costliest) ? 0 : 1;
  }
  if (argc == 3 && std::string(argv[1]) == "count") {
    const std::vector<Moment> moments = read(argv[2]);
    for (const Moment& now : moments) {
      const auto prepared = session_settings(now.session);
      auto state = now.before;
      counted_step(prepared, state, now);
    }
    return moments.empty() ? 1 : 0;
  }
  std::fputs("usage: worst_steps FILE | worst_steps count FILE\n", stderr);
  return 2;
}
