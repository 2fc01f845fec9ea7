#pragma once

namespace smaservo {

/// Does what the command line says; the exit code. Throws what its command throws.
int run_host_sim(int argc, char** argv);

}  // namespace smaservo
