// For programs without MPI.

#include <fmt/format.h>

#include "host-sim/campaign/cluster/ranks.hpp"
#include "model/files/error.hpp"

namespace smaservo::campaign {

std::unique_ptr<Ranks> join_ranks(const StartedTogether& started) {
  throw files::UserError(fmt::format(
      "this is one of {0} processes that were started together ({1}={0}), and each would compute "
      "the whole campaign, since this host-sim is built without MPI. Build it with "
      "-DSMASERVO_MPI=ON, or give each process its part by --shard K/{0}, or start one process",
      started.count, started.variable));
}

}  // namespace smaservo::campaign
