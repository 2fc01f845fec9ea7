// For programs with MPI, of which only the interface for C is used.

#include <array>
#include <fmt/format.h>
#include <mpi.h>
#include <string_view>

#include "host-sim/campaign/cluster/ranks.hpp"
#include "model/files/error.hpp"

namespace smaservo::campaign {
namespace {

/// The library's own name and version, its first line.
std::string library_version() {
  std::array<char, MPI_MAX_LIBRARY_VERSION_STRING> text{};
  int length = 0;
  MPI_Get_library_version(text.data(), &length);
  const std::string_view whole(text.data(), static_cast<std::size_t>(length));
  return std::string(whole.substr(0, whole.find_first_of(",\n")));
}

/// MPI from its begin to its end. An error of MPI itself ends all ranks, with its own message.
class MpiRanks final : public Ranks {
 public:
  MpiRanks() {
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
    int rank = 0;
    int count = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &count);
    rank_ = static_cast<std::uint64_t>(rank);
    count_ = static_cast<std::uint64_t>(count);
    threads_ = provided >= MPI_THREAD_SERIALIZED;
  }
  ~MpiRanks() override { MPI_Finalize(); }
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks& operator=(const MpiRanks&) = delete;

  std::uint64_t rank() const override { return rank_; }
  std::uint64_t count() const override { return count_; }
  bool threads() const { return threads_; }

  std::optional<Numbers> combine(const Numbers& own, How how) override {
    if (request_ == MPI_REQUEST_NULL) {
      own_ = own;
      MPI_Iallreduce(own_.data(), combined_.data(), static_cast<int>(own_.size()), MPI_UINT64_T,
                     how == How::sum ? MPI_SUM : MPI_MAX, MPI_COMM_WORLD, &request_);
    }
    int complete = 0;
    MPI_Test(&request_, &complete, MPI_STATUS_IGNORE);
    return complete != 0 ? std::optional(combined_) : std::nullopt;
  }

 private:
  std::uint64_t rank_ = 0, count_ = 1;
  bool threads_ = false;
  Numbers own_{}, combined_{};
  MPI_Request request_ = MPI_REQUEST_NULL;
};

}  // namespace

std::unique_ptr<Ranks> join_ranks(const StartedTogether& started) {
  auto ranks = std::make_unique<MpiRanks>();
  if (ranks->count() != started.count) {
    throw files::UserError(fmt::format(
        "this is one of {} processes that were started together ({}), but this host-sim's MPI, {}, "
        "finds {}: start it by the mpirun of this MPI, or by an srun --mpi=... that it knows",
        started.count, started.variable, library_version(), ranks->count()));
  }
  if (!ranks->threads()) {
    throw files::UserError(fmt::format(
        "this MPI, {}, cannot be called by several threads in turn (MPI_THREAD_SERIALIZED)",
        library_version()));
  }
  return ranks;
}

}  // namespace smaservo::campaign
