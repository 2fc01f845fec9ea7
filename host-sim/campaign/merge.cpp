#include "host-sim/campaign/merge.hpp"

#include <fmt/format.h>

#include "host-sim/shell_word.hpp"
#include "model/files/error.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::campaign {
namespace {

/// "0 to 3": chunks, and "of trials 0 to 399".
std::string range_text(const Plan& plan, std::uint64_t first, std::uint64_t last) {
  const std::string chunks =
      first == last ? fmt::format("{}", first) : fmt::format("{} to {}", first, last);
  return fmt::format("{} (trials {} to {})", chunks, plan.first(first), plan.first(last + 1) - 1);
}

/// What stands in the way of the merge.
class Obstacles {
 public:
  Obstacles(const Campaign& campaign, const Folder& folder) : campaign_(campaign), folder_(folder) {
    for (std::uint64_t i = 0; i < campaign.plan.chunks(); ++i) {
      look_at(i);
    }
    end_hole(campaign.plan.chunks());
  }

  std::string text() const {
    std::vector<std::string> all = problems_;
    if (!holes_.empty()) {
      all.push_back(fmt::format("chunks are missing: {}", some_of(holes_, ", ")));
    }
    const std::vector<std::string> strangers = folder_.strangers(campaign_);
    if (!strangers.empty()) {
      all.push_back(fmt::format(
          "{}/chunks has files that are no chunks of this plan, and may hold trials twice: {}; "
          "remove them",
          folder_.path(), some_of(strangers, ", ")));
    }
    return some_of(all, "; ");
  }
  bool can_be_computed() const { return computable_; }

 private:
  void look_at(std::uint64_t number) {
    const ChunkFile file = folder_.chunk(campaign_, number);
    if (file.state == ChunkState::missing) {
      hole_ = in_hole_ ? hole_ : number;
      in_hole_ = true;
      computable_ = true;
      return;
    }
    end_hole(number);
    if (file.state != ChunkState::whole) {
      computable_ = computable_ || file.state == ChunkState::broken;
      problems_.push_back(fmt::format("{} {}{}", folder_.chunk_path(number), file.problem,
                                      file.state == ChunkState::foreign ? ": remove it" : ""));
    }
  }

  void end_hole(std::uint64_t past) {
    if (in_hole_) {
      holes_.push_back(range_text(campaign_.plan, hole_, past - 1));
    }
    in_hole_ = false;
  }

  const Campaign& campaign_;
  const Folder& folder_;
  std::vector<std::string> holes_, problems_;
  std::uint64_t hole_ = 0;
  bool in_hole_ = false, computable_ = false;
};

}  // namespace

void merge(const Campaign& campaign, const Folder& folder) {
  const Obstacles obstacles(campaign, folder);
  const std::string text = obstacles.text();
  if (!text.empty()) {
    throw files::UserError(fmt::format(
        "{}: cannot be merged: {}{}", folder.path(), text,
        obstacles.can_be_computed()
            ? fmt::format(
                  ". What is missing or broken is computed by: host-sim campaign {} --out {}",
                  shell_word(campaign.plan.path), shell_word(folder.path()))
            : ""));
  }
  files::OutputFile output(folder.trials_path());
  output.write(csv_head(campaign.trials->columns()));
  for (std::uint64_t i = 0; i < campaign.plan.chunks(); ++i) {
    const ChunkFile file = folder.chunk(campaign, i);
    if (file.state != ChunkState::whole) {
      throw files::UserError(fmt::format("{}: {}", folder.chunk_path(i), file.problem));
    }
    output.write(file.rows());
    for (const TrialFile& left : file.files()) {
      files::OutputFile own(folder.file_path(left.name));
      own.write(left.text);
      own.commit();
    }
  }
  output.commit();
}

}  // namespace smaservo::campaign
