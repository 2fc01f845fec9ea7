#include "tests/places.hpp"

namespace smaservo::test {

const std::string& source_folder() {
  static const std::string folder = SMASERVO_SOURCE_DIR;
  return folder;
}

const std::string& shared_folder() {
  static const std::string folder = SMASERVO_SHARED_DEFAULT;
  return folder;
}

const std::string& daemon_program() {
  static const std::string program = SMASERVO_BINARY_DIR "/firmware/daemon/smaservod";
  return program;
}

const std::string& host_sim_program() {
  static const std::string program = SMASERVO_BINARY_DIR "/host-sim/host-sim";
  return program;
}

const std::string& host_sim_mpi_program() {
  static const std::string program = SMASERVO_BINARY_DIR "/tests/host-sim/host-sim-mpi";
  return program;
}

const std::string& own_observer_program() {
  static const std::string program = SMASERVO_BINARY_DIR "/tests/host-sim/own_observer";
  return program;
}

}  // namespace smaservo::test
