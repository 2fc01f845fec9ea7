#pragma once
// Where tests find the project's files and programs. The paths are compiled into places.cpp alone,
// so that every other object is the same in each clone, and ccache knows it again.

#include <string>

namespace smaservo::test {

/// The project's top folder.
const std::string& source_folder();

/// Folder of measured data of others (SMASERVO_SHARED); may be missing.
const std::string& shared_folder();

/// smaservod and host-sim of this build.
const std::string& daemon_program();
const std::string& host_sim_program();

/// host-sim with MPI; is not there where this machine has no MPI, and with sanitizers.
const std::string& host_sim_mpi_program();

/// The observer of tests/host-sim/evaluate/own_observer.
const std::string& own_observer_program();

}  // namespace smaservo::test
