#include "host-sim/campaign/cluster/slurm.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "hal/linux/system/descriptor.hpp"
#include "hal/recording/start_program.hpp"
#include "host-sim/campaign/folder.hpp"
#include "host-sim/hash.hpp"
#include "host-sim/shell_word.hpp"
#include "host-sim/temporary_folder.hpp"
#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/message.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::campaign {
namespace {

/// Clusters let a user have some hundred or thousand jobs, and each task counts as one.
constexpr std::uint64_t usual_tasks = 100;
constexpr const char* shards_name = "campaign.sbatch";
constexpr const char* merge_name = "merge.sbatch";
constexpr std::string_view end_of_script = "# As host-sim wrote it; checksum ";

bool is_letter_or_digit(char c) {
  return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9');
}

/// The name of the plan's file without what has a meaning for Slurm or a shell.
std::string job_name(const std::string& plan) {
  std::string name = std::filesystem::path(plan).stem().string();
  std::ranges::replace_if(
      name, [](char c) { return !is_letter_or_digit(c) && c != '-' && c != '.'; }, '_');
  return "campaign-" + name;
}

/// A value of a line #SBATCH. sbatch takes a backslash inside of quotes as an escape.
std::string sbatch_word(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  }
  return quoted + '"';
}

void refuse_folder_names(const std::string& out) {
  const auto is_wrong = [](char c) {
    return c == '%' || c == '\\' || static_cast<unsigned char>(c) < ' ';
  };
  if (std::ranges::any_of(out, is_wrong)) {
    throw files::UserError(fmt::format(
        "--out {}: Slurm takes %, \\ and line breaks in the name of a log's folder for something "
        "else; choose another folder",
        out));
  }
}

std::string with_checksum(const std::string& text) {
  return text + fmt::format("{}{}\n", end_of_script, hash_of(text));
}

/// What both scripts begin with.
std::string script_head(const SlurmCalls& calls, const std::string& name, const std::string& what,
                        const std::string& log) {
  refuse_folder_names(calls.out);
  return fmt::format(R"(#!/bin/sh
# {}
# Written by host-sim campaign --slurm. Where your cluster needs more, take one # away and fill in,
# or give it to sbatch as SBATCH_PARTITION, SBATCH_ACCOUNT, SBATCH_TIMELIMIT:
##SBATCH --partition=NAME
##SBATCH --account=NAME
##SBATCH --time=1-00:00:00
##SBATCH --mem-per-cpu=1G
#SBATCH --job-name={}
#SBATCH --chdir={}
#SBATCH --output={}
# A task of a node that was lost, or that gave way to other jobs, is started again.
#SBATCH --requeue
#SBATCH --open-mode=append
)",
                     what, name, sbatch_word(calls.out), log);
}

/// "PROGRAM campaign PLAN --out FOLDER". The program takes the shell's place, so that signals reach
/// it.
std::string script_call(const SlurmCalls& calls) {
  return fmt::format("exec {} campaign {} --out {}", shell_word(calls.program),
                     shell_word(calls.plan), shell_word(calls.out));
}

std::string own_program() {
  std::error_code error;
  const std::filesystem::path path = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error || !std::filesystem::exists(path, error)) {
    throw files::UserError(
        "--slurm: the file of this program has been replaced or removed; start it again");
  }
  return path.string();
}

/// A dash is the standard output: of a job, its log.
std::string absolute(const std::string& path) {
  return path.empty() || path == "-" ? path : std::filesystem::absolute(path).string();
}

std::string merge_options(const std::string& job) {
  return fmt::format("--dependency=afterok:{} --kill-on-invalid-dep=yes", job);
}

/// Where the scripts are, and how a person submits them.
struct ScriptPaths {
  std::string shards, merge;

  std::string by_hand() const {
    return fmt::format("job=$(sbatch --parsable {}) && sbatch {} {}", shell_word(shards),
                       merge_options("$job"), shell_word(merge));
  }
};

/// A script that somebody has changed is theirs.
void refuse_changed(const std::string& path, const ScriptPaths& all) {
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored) && !is_as_written(files::whole_file(path))) {
    throw files::UserError(fmt::format(
        "{}: has been changed by hand and is kept. Remove it to have it written anew, or submit it "
        "so, also to go on: {}",
        path, all.by_hand()));
  }
}

void write_script(const std::string& path, const std::string& script) {
  files::OutputFile file(path);
  file.write(script);
  file.commit();
}

struct Ended {
  int status;  ///< 0: well
  std::string out, err;
};

/// Runs sbatch, as the PATH has it; that it is missing is an end with words, too.
Ended run_sbatch(std::vector<std::string> arguments) {
  const TemporaryFolder folder;
  const std::array<std::string, 2> names{(folder / "out").string(), (folder / "err").string()};
  const hal::Descriptor none(open("/dev/null", O_RDONLY | O_CLOEXEC));
  constexpr int flags = O_WRONLY | O_CREAT | O_CLOEXEC;
  const hal::Descriptor out(open(names[0].c_str(), flags, 0600));
  const hal::Descriptor err(open(names[1].c_str(), flags, 0600));
  arguments.insert(arguments.begin(), "sbatch");
  pid_t child = 0;
  const int failed = hal::start_program({.program = "/usr/bin/env",
                                         .arguments = std::move(arguments),
                                         .input = none.number(),
                                         .output = out.number(),
                                         .errors = err.number(),
                                         .environment = environ},
                                        child);
  if (failed != 0) {
    return {failed, "", std::strerror(failed)};
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return {status, files::whole_file(names[0]), files::whole_file(names[1])};
}

std::string_view last_line(std::string_view text) {
  while (text.ends_with('\n')) {
    text.remove_suffix(1);
  }
  return text.substr(text.rfind('\n') + 1);
}

/// The number of the job that sbatch --parsable has said: "12" or "12;CLUSTER", after what others
/// may have added. Empty: none.
std::string job_number(std::string_view said) {
  const std::string_view line = last_line(said);
  const std::string number(line.substr(0, line.find(';')));
  const bool good =
      !number.empty() && std::ranges::all_of(number, [](char c) { return '0' <= c && c <= '9'; });
  return good ? number : "";
}

/// Submits a script and returns the job's number. `otherwise` is what a user does if this fails.
std::string submitted(std::vector<std::string> options, const std::string& script,
                      const std::string& otherwise) {
  options.insert(options.begin(), "--parsable");
  options.push_back(script);
  const Ended ended = run_sbatch(std::move(options));
  const std::string number = ended.status == 0 ? job_number(ended.out) : "";
  if (number.empty()) {
    throw files::UserError(
        fmt::format("sbatch has submitted nothing: {}. {}",
                    last_line(last_line(ended.err).empty() ? ended.out : ended.err), otherwise));
  }
  if (!last_line(ended.err).empty()) {
    files::complain("sbatch", last_line(ended.err));
  }
  return number;
}

void submit_both(const Campaign& campaign, const SlurmCalls& calls, const ScriptPaths& paths) {
  const std::string job =
      submitted({}, paths.shards,
                fmt::format("The scripts are written; fill in what your cluster needs, and submit "
                            "them where Slurm is: {}",
                            paths.by_hand()));
  const std::string joins =
      submitted({"--dependency=afterok:" + job, "--kill-on-invalid-dep=yes"}, paths.merge,
                fmt::format("Job {} computes the chunks; then this joins them: sbatch {} {}", job,
                            merge_options(job), shell_word(paths.merge)));
  files::print(files::printable_lines(fmt::format(
      R"({} chunks in {} tasks: job {}. Job {} joins them when all tasks have ended well; if one
fails, Slurm cancels it.
  state      squeue --job {},{}
  progress   tail -qn 1 {}/slurm-{}_*.log
  go on      the same command again, after a failure, a time limit or scancel
  cancel     scancel {} {}
)",
      campaign.plan.chunks(), calls.tasks, job, joins, job, joins, shell_word(calls.out), job, job,
      joins)));
}

}  // namespace

std::uint64_t slurm_tasks(const Plan& plan, std::optional<std::uint64_t> asked) {
  if (asked && *asked > plan.chunks()) {
    throw files::UserError(
        fmt::format("--tasks {}: the plan has {} chunks, and a task computes at least one; give "
                    "fewer tasks, or the plan a smaller chunk",
                    *asked, plan.chunks()));
  }
  return asked ? *asked : std::min(usual_tasks, plan.chunks());
}

std::string shards_script(const SlurmCalls& calls) {
  return with_checksum(
      script_head(
          calls, job_name(calls.plan),
          "Computes the chunks of a campaign. Submitted again, it computes what is missing.",
          "slurm-%A_%a.log") +
      fmt::format("#SBATCH --array=0-{}\n#SBATCH --cpus-per-task={}\n{} \\\n"
                  "  --shard \"${{SLURM_ARRAY_TASK_ID:?is set by sbatch}}/{}\" "
                  "--threads \"${{SLURM_CPUS_PER_TASK:-1}}\"\n",
                  calls.tasks - 1, calls.threads, script_call(calls), calls.tasks));
}

std::string merge_script(const SlurmCalls& calls) {
  const std::string report =
      calls.report.empty() ? "" : fmt::format(" --report {}", shell_word(calls.report));
  return with_checksum(script_head(calls, job_name(calls.plan) + "-merge",
                                   "Joins the chunks of a campaign when all of them are there.",
                                   "slurm-%j-merge.log") +
                       fmt::format("{} --merge{}\n", script_call(calls), report));
}

bool is_as_written(std::string_view script) {
  const std::size_t end = script.rfind(end_of_script);
  return end != std::string_view::npos &&
         script == with_checksum(std::string(script.substr(0, end)));
}

void run_on_slurm(const Campaign& campaign, const SlurmRequest& request) {
  const SlurmCalls calls{own_program(),
                         absolute(campaign.plan.path),
                         absolute(request.out),
                         absolute(request.report),
                         slurm_tasks(campaign.plan, request.tasks),
                         request.threads};
  const std::string of_shards = shards_script(calls);
  const std::string of_merge = merge_script(calls);
  const Folder folder = Folder::prepared(campaign, request.out);
  const std::filesystem::path path = calls.out;
  const ScriptPaths paths{(path / shards_name).string(), (path / merge_name).string()};
  refuse_changed(paths.shards, paths);
  refuse_changed(paths.merge, paths);
  write_script(paths.shards, of_shards);
  write_script(paths.merge, of_merge);
  if (request.submit) {
    submit_both(campaign, calls, paths);
  } else {
    files::print(files::printable_lines("The scripts are written. This submits them:\n  " +
                                        paths.by_hand() + "\n"));
  }
}

}  // namespace smaservo::campaign
