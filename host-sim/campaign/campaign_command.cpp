#include "host-sim/campaign/campaign_command.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <thread>

#include "host-sim/campaign/cluster/slurm.hpp"
#include "host-sim/campaign/cluster/together.hpp"
#include "host-sim/campaign/kinds/kinds.hpp"
#include "host-sim/campaign/merge.hpp"
#include "host-sim/campaign/report.hpp"
#include "host-sim/campaign/run.hpp"
#include "host-sim/end_by_signal.hpp"
#include "host-sim/evaluate/table.hpp"
#include "host-sim/shell_word.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"
#include "model/files/progress.hpp"

namespace smaservo::campaign {
namespace {

constexpr int most_threads = 1024;

struct CampaignArguments {
  std::string plan, out, shard, report, markdown;
  std::optional<std::int64_t> trial;
  int threads = 1;
  bool merge = false;
  bool slurm = false, no_submit = false, threads_are_given = false;
  std::optional<std::uint64_t> tasks;
};

/// Prints one trial, with the command that shows more of it.
void run_trial(const Campaign& campaign, std::int64_t trial) {
  const auto index = static_cast<std::uint64_t>(trial);
  if (trial < 0 || index >= campaign.plan.trials) {
    throw files::UserError(fmt::format("--trial {}: the plan has the trials 0 to {}", trial,
                                       campaign.plan.trials - 1));
  }
  const EndBySignal end;
  const TrialResult result = campaign.trials->run(index, EndBySignal::came);
  files::print(row_text(campaign.trials->columns(), result.row));
  const std::string command = campaign.trials->command(index);
  if (!command.starts_with("host-sim campaign")) {
    files::complain("host-sim", "more of it shows: " + command);
  }
}

/// Joins the chunks, prints what their rows show, and writes it as a report.
void finish(const Campaign& campaign, const Folder& folder, const CampaignArguments& a) {
  merge(campaign, folder);
  const Report report = make_report(campaign, folder, !a.markdown.empty());
  files::print(files::printable_lines(report_text(campaign, report)));
  if (!a.markdown.empty()) {
    evaluate::TableFile(a.markdown, report.table->mark()).rewrite(report.table->markdown());
  }
  if (!a.report.empty()) {
    write_report(a.report, campaign, report);
  }
}

/// A signal ends the run between two trials.
RunOptions options_of(const CampaignArguments& a) {
  RunOptions options;
  options.shard = a.shard.empty() ? Shard{} : shard_of(a.shard);
  options.threads = a.threads;
  options.stop = EndBySignal::came;
  options.warn = [](const std::string& text) { files::complain("host-sim", text); };
  options.progress = [line = std::make_shared<std::optional<files::Progress>>()](
                         std::uint64_t done, std::uint64_t total) {
    if (!*line) {
      line->emplace("campaign", total);
    }
    (*line)->update(done);
  };
  return options;
}

std::string counts_text(const RunResult& result) {
  return fmt::format("{} chunk{}: {} computed, {} were there", result.chunks,
                     result.chunks == 1 ? "" : "s", result.computed, result.found);
}

void finish_run(const Campaign& campaign, const Folder& folder, const CampaignArguments& a,
                const RunResult& result) {
  finish(campaign, folder, a);
  files::print(fmt::format("\n{}; {} trials in {}\n", counts_text(result), campaign.plan.trials,
                           files::printable(folder.trials_path())));
}

void run_all(const Campaign& campaign, const CampaignArguments& a) {
  const EndBySignal end;
  const Folder folder = Folder::prepared(campaign, a.out);
  const RunResult result = run_campaign(campaign, folder, options_of(a));
  if (result.stopped) {
    files::complain("host-sim",
                    fmt::format("interrupted: {}. The same command goes on", counts_text(result)));
  } else if (a.shard.empty()) {
    finish_run(campaign, folder, a, result);
  } else {
    files::print(fmt::format(
        "shard {}: {}. All shards are joined by: host-sim campaign {} --out {} --merge\n", a.shard,
        counts_text(result), files::printable(shell_word(a.plan)),
        files::printable(shell_word(a.out))));
  }
}

/// Refuses a kind that has no such table, and a file that has no place for it.
void check_markdown(const Campaign& campaign, const std::string& path) {
  if (path.empty()) {
    return;
  }
  const std::unique_ptr<const Table> table = campaign.trials->table();
  if (!table || table->mark().empty()) {
    throw files::UserError(
        fmt::format("--markdown {}: the kind {} has no table for a Markdown file; scenarios and "
                    "evaluate have one",
                    path, campaign.plan.kind));
  }
  const evaluate::TableFile file(path, table->mark());
}

/// Reads the plan, when the options are seen to be right: its files may take a while.
Campaign campaign_of(const CampaignArguments& a) {
  refuse_to_overwrite(a.plan, a.report);
  refuse_to_overwrite(a.plan, a.markdown);
  refuse_to_overwrite(a.markdown, a.report);
  if (!a.shard.empty()) {
    shard_of(a.shard);
  }
  if (a.out.empty() && !a.trial) {
    throw files::UserError("--out is missing: the folder of the results");
  }
  return read_plan(a.plan, all_kinds());
}

/// That the results cannot be written is told at the start, not after hours.
void check_outputs(const Campaign& campaign, const CampaignArguments& a) {
  check_markdown(campaign, a.markdown);
  if (!a.report.empty()) {
    const files::OutputFile writable(a.report);
  }
}

/// Rank 0 prepares the folder, each rank computes a shard, and rank 0 joins them.
void run_in_ranks(Ranks& ranks, const CampaignArguments& a, std::optional<EndBySignal>& end) {
  std::optional<Campaign> campaign;
  std::optional<Folder> folder;
  std::optional<hal::Descriptor> lock;  // against the same campaign with another number of ranks
  const bool first = ranks.rank() == 0;
  all_do(ranks, [&] {
    if (a.merge || a.slurm) {
      throw files::UserError(fmt::format("{} computes nothing: start it as one process",
                                         a.merge ? "--merge" : "--slurm"));
    }
    campaign = campaign_of(a);
    if (first) {
      check_outputs(*campaign, a);
      folder = Folder::prepared(*campaign, a.out);
      lock = folder->lock({});
    }
  });
  all_do(ranks, [&] {
    if (!first) {
      folder = Folder::existing(*campaign, a.out);
    }
  });
  RunResult result;
  all_do(ranks, [&] { result = run_together(ranks, *campaign, *folder, options_of(a)); });
  if (!first) {
    end.reset();  // it only waits from now on
  }
  all_do(ranks, [&] {
    if (first) {
      finish_run(*campaign, *folder, a, result);
    }
  });
}

/// One process of several that were started together.
void run_as_rank(const StartedTogether& started, const CampaignArguments& a) {
  const std::unique_ptr<Ranks> ranks = join_ranks(started);
  std::optional<EndBySignal> end(std::in_place);
  try {
    run_in_ranks(*ranks, a, end);
  } catch (const EndedTogether&) {
    throw CLI::RuntimeError(1);
  } catch (const EndedBySignal&) {
    if (ranks->rank() == 0) {
      files::complain("host-sim", "interrupted; whole chunks are kept. The same command goes on");
    }
  }
}

void run(const CampaignArguments& a) {
  const StartedTogether started = started_together();
  // With these each process has work of its own, whoever has started it.
  const bool alone = !a.shard.empty() || a.trial;
  if (started.count > 1 && !alone) {
    run_as_rank(started, a);
    return;
  }
  const Campaign campaign = campaign_of(a);
  check_outputs(campaign, a);
  if (a.trial) {
    run_trial(campaign, *a.trial);
  } else if (a.merge) {
    const Folder folder = Folder::existing(campaign, a.out);
    finish(campaign, folder, a);
    files::print(fmt::format("\n{} trials in {}\n", campaign.plan.trials,
                             files::printable(folder.trials_path())));
  } else if (a.slurm) {
    // This computer's processors say nothing about those of the cluster.
    run_on_slurm(campaign, {.out = a.out,
                            .report = a.report,
                            .tasks = a.tasks,
                            .threads = a.threads_are_given ? a.threads : 1,
                            .submit = !a.no_submit});
  } else {
    run_all(campaign, a);
  }
}

/// Options that give the work to Slurm instead.
void add_slurm_options(CLI::App& command, CampaignArguments& a) {
  CLI::Option* const slurm =
      command.add_flag("--slurm", a.slurm,
                       "computes nothing here: submits an array of tasks and the merge to Slurm; "
                       "--threads are processors of a task, 1 if not given");
  slurm->excludes("--shard", "--merge", "--trial", "--markdown");
  command.add_option("--tasks", a.tasks, "number of Slurm's tasks; if not given, up to 100")
      ->check(CLI::Range(std::uint64_t{1}, most_slurm_tasks))
      ->needs(slurm);
  command
      .add_flag("--no-submit", a.no_submit,
                "only writes the scripts for sbatch into the folder, to be edited")
      ->needs(slurm);
}

}  // namespace

void add_campaign_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "campaign", "Runs many trials of a plan in chunks, divided as one likes, and joins them.");
  auto a = std::make_shared<CampaignArguments>();
  if (started_together().count == 1) {
    a->threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  }
  command->add_option("plan", a->plan, "TOML file; its keys: host-sim/campaign/README.md")
      ->required();
  command->add_option("--out", a->out,
                      "folder of the results; chunks that are in it are not computed again");
  CLI::Option* const shard =
      command->add_option("--shard", a->shard, "K/N: only part K, from 0 to N-1, of N parts");
  command
      ->add_option("--threads", a->threads,
                   "of each process; the result is the same for any; 1 in a rank of MPI")
      ->check(CLI::Range(1, most_threads))
      ->capture_default_str();
  CLI::Option* const merge = command->add_flag(
      "--merge", a->merge, "computes nothing: joins the chunks that shards have computed");
  merge->excludes(shard);
  command->add_option("--report", a->report, "what the rows show, as one HTML file")
      ->excludes(shard);
  command
      ->add_option("--markdown", a->markdown,
                   "Markdown file in which the kind's own table is replaced")
      ->excludes(shard);
  command
      ->add_option("--trial", a->trial,
                   "runs one trial by its number, and prints its row; no --out")
      ->excludes("--out", "--shard", "--merge", "--report", "--markdown");
  add_slurm_options(*command, *a);
  command->callback([a, command] {
    a->threads_are_given = command->count("--threads") > 0;
    run(*a);
  });
}

}  // namespace smaservo::campaign
