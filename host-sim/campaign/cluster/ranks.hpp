#pragma once
// Processes that mpirun or srun has started together to work on one campaign: ranks.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace smaservo::campaign {

/// How many processes were started together with this one, as its environment says.
struct StartedTogether {
  std::uint64_t count = 1;
  std::string variable;  ///< the environment's variable that says so; empty: there is none
};

/// By mpirun of Open MPI or of MPICH and its relatives, or as a step of Slurm (srun). The process
/// of a batch script of Slurm was started alone, whatever the job asks for.
StartedTogether started_together();

/// Processes that can add up numbers of each other.
class Ranks {
 public:
  using Numbers = std::array<std::uint64_t, 8>;
  enum class How : unsigned char { sum, greatest };

  Ranks() = default;
  virtual ~Ranks() = default;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  virtual std::uint64_t rank() const = 0;  ///< of this process, 0 to count() - 1
  virtual std::uint64_t count() const = 0;
  /// Combines the numbers of all ranks, each place by itself. Does not wait: the first call begins
  /// with the numbers of this rank; that and the next calls, which ignore `own`, give nothing until
  /// all ranks have begun, then the result, the same for all. The call after that begins anew. All
  /// ranks must ask for the same in the same order. To be called by one thread at a time.
  virtual std::optional<Numbers> combine(const Numbers& own, How how) = 0;
};

/// Joins the ranks that this process was started with. Two sources have this function: mpi.cpp for
/// programs with MPI; in no_mpi.cpp it throws UserError, which says what to do instead.
std::unique_ptr<Ranks> join_ranks(const StartedTogether& started);

}  // namespace smaservo::campaign
