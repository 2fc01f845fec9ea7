// Artificial work in the way of the loop: so many microseconds of each millisecond, before all
// else.

#include <cstdlib>
#include <ctime>
#include <sched.h>

namespace {

long clock_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

int main(int argc, char** argv) {
  const long busy_ns = argc > 1 ? 1000 * std::strtol(argv[1], nullptr, 10) : 0;
  const sched_param priority{.sched_priority = 90};
  if (sched_setscheduler(0, SCHED_FIFO, &priority) != 0) {
    return 1;
  }
  for (;;) {
    const long until_ns = clock_ns() + busy_ns;
    while (clock_ns() < until_ns) {
    }
    const timespec rest{0, 100'000};
    clock_nanosleep(CLOCK_MONOTONIC, 0, &rest, nullptr);
  }
}
