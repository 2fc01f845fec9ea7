#include <cstdio>
#include <exception>

#include "host-sim/run.hpp"

int main(int argc, char** argv) {
  try {
    return smaservo::run_host_sim(argc, argv);
  } catch (const std::exception& error) {
    std::fputs("host-sim: ", stderr);
    std::fputs(error.what(), stderr);
    std::fputs("\n", stderr);
  }
  return 1;
}
