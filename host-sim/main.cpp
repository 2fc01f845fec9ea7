#include <exception>

#include "host-sim/run.hpp"
#include "model/files/message.hpp"

int main(int argc, char** argv) {
  try {
    return smaservo::run_host_sim(argc, argv);
  } catch (const std::exception& error) {
    smaservo::files::complain("host-sim", error.what());
  }
  return 1;
}
