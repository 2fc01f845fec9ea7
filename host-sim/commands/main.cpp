#include <exception>

#include "host-sim/commands/commands.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

int main(int argc, char** argv) {
  smaservo::files::hold_standard_descriptors();
  try {
    return smaservo::commands::run_host_sim(argc, argv);
  } catch (const smaservo::files::NoResult& failure) {
    smaservo::files::complain("host-sim", failure.what());
    return 3;
  } catch (const std::exception& error) {
    smaservo::files::complain("host-sim", error.what());
  }
  return 1;
}
