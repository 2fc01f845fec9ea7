#pragma once
// Gives a campaign to Slurm: an array of tasks, each of which computes a shard, and a job that
// joins their chunks.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "host-sim/campaign/plan.hpp"

namespace smaservo::campaign {

inline constexpr std::uint64_t most_slurm_tasks = 1000;

/// What is asked for.
struct SlurmRequest {
  std::string out, report;  ///< as they were given; report: may be empty
  std::optional<std::uint64_t> tasks;
  int threads = 1;     ///< processors of a task
  bool submit = true;  ///< false: only writes the scripts
};

/// What the scripts call. Paths are absolute.
struct SlurmCalls {
  std::string program, plan, out;
  std::string report;  ///< empty: none
  std::uint64_t tasks;
  int threads;
};

/// Number of tasks: at most one for each chunk. Throws UserError if more are asked for.
std::uint64_t slurm_tasks(const Plan& plan, std::optional<std::uint64_t> asked);

/// The scripts for sbatch: of the shards, and of the job that joins them. Throws UserError if Slurm
/// cannot write into a folder of this name.
std::string shards_script(const SlurmCalls& calls);
std::string merge_script(const SlurmCalls& calls);

/// Whether nobody has changed a script since it was written.
bool is_as_written(std::string_view script);

/// Prepares the folder as a run does, writes the scripts into it and submits them. Throws
/// UserError: if a script has been changed by hand, which is kept then; and if sbatch is missing or
/// refuses, with its words.
void run_on_slurm(const Campaign& campaign, const SlurmRequest& request);

}  // namespace smaservo::campaign
