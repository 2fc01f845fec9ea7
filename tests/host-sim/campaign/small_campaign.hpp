#pragma once
// A campaign whose trials cost nothing, for tests of the engine.

#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <map>
#include <string>

#include "host-sim/campaign/merge.hpp"
#include "host-sim/campaign/run.hpp"
#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::campaign::test {

using smaservo::test::file_text;
using smaservo::test::TemporaryFolder;

/// Is called before each trial of a small campaign, by several threads.
inline std::function<void(std::uint64_t)>& before_trial() {
  static std::function<void(std::uint64_t)> function = [](std::uint64_t) {};
  return function;
}

class SmallTrials final : public Trials {
 public:
  explicit SmallTrials(std::uint64_t seed, bool leave_files)
      : seed_(seed), leave_files_(leave_files) {}
  const std::vector<Column>& columns() const override {
    static const std::vector<Column> all{
        {"seed", true}, {"class", true, true}, {"value_m", false}, {"maybe_s", false}};
    return all;
  }
  std::string_view main_column() const override { return "value_m"; }
  double cost_s() const override { return 1; }
  TrialResult run(std::uint64_t index, const Stop& /*stop*/) const override {
    before_trial()(index);
    const auto number = static_cast<double>(index);
    TrialResult result{{seed_ + index, index % 3 == 0 ? "a, \"b\"" : "c", std::sin(number) / 3,
                        index % 2 == 0 ? std::numeric_limits<double>::quiet_NaN() : number}};
    if (leave_files_ && index % 50 == 0) {
      result.files = {{fmt::format("{}.txt", index), left_text(index)},
                      {fmt::format("{} empty", index), ""}};
    }
    return result;
  }
  std::string command(std::uint64_t index) const override { return fmt::format("run {}", index); }

  /// A file that looks like parts of a chunk.
  static std::string left_text(std::uint64_t index) {
    return fmt::format("# file 3 a\n1,2\n\n# end: 70 rows, checksum {}\n", index);
  }

 private:
  std::uint64_t seed_;
  bool leave_files_;
};

inline std::unique_ptr<const Trials> read_small(KindTable& table) {
  if (table.keys().has("file")) {
    table.depends_on("file", table.keys().text("file"), table.path("file"));
  }
  return std::make_unique<SmallTrials>(table.plan().seed, table.keys().flag("with_notes", false));
}

inline constexpr std::array small_kinds{Kind{"small", read_small}};

/// 1000 trials in 15 chunks, the last one with 20 trials.
inline const std::string small_plan =
    "kind = 'small'\ntrials = 1000\nseed = 7\nchunk = 70\n[small]\n";

inline Campaign small_campaign(const TemporaryFolder& folder, const std::string& plan = small_plan,
                               const std::string& version = "1.2.3") {
  return read_plan(folder.write("plan.toml", plan), small_kinds, version);
}

/// Runs one shard into this folder.
inline RunResult run_into(const Campaign& campaign, const std::string& out, Shard shard = {},
                          int threads = 1) {
  RunOptions options;
  options.shard = shard;
  options.threads = threads;
  return run_campaign(campaign, Folder::prepared(campaign, out), options);
}

inline void merge_in(const Campaign& campaign, const std::string& out) {
  merge(campaign, Folder::existing(campaign, out));
}

/// The contents of a folder's files but the locks, by their names.
inline std::map<std::string, std::string> contents(const std::string& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (entry.is_regular_file() && !name.starts_with("lock-")) {
      all[name] = file_text(entry.path().string());
    }
  }
  return all;
}

/// The message of the error that ends the work; empty if there is none.
template <class Work>
std::string error_of(const Work& work) {
  try {
    work();
  } catch (const files::UserError& error) {
    return error.what();
  }
  return "";
}

}  // namespace smaservo::campaign::test
