#include "host-sim/campaign/cluster/ranks.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string_view>

namespace smaservo::campaign {
namespace {

std::string_view environment(const char* name) {
  const char* const value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): at the start
  return value == nullptr ? "" : value;
}

}  // namespace

StartedTogether started_together() {
  // SLURM_NTASKS and SLURM_PROCID are set in batch scripts, too; only a step has its own number of
  // tasks. An mpirun within a step or a batch script counts itself.
  for (const char* const name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"}) {
    const std::string_view value = environment(name);
    std::uint64_t count = 0;
    const auto read = std::from_chars(value.data(), value.data() + value.size(), count);
    const bool is_task =
        !std::string_view(name).starts_with("SLURM") || !environment("SLURM_PROCID").empty();
    if (read.ec == std::errc{} && read.ptr == value.data() + value.size() && is_task) {
      return {std::max<std::uint64_t>(count, 1), name};
    }
  }
  return {};
}

}  // namespace smaservo::campaign
