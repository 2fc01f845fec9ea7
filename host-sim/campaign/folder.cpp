#include "host-sim/campaign/folder.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <sys/file.h>

#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::campaign {

namespace fs = std::filesystem;

namespace {

constexpr const char* identity_name = "identity.txt";
constexpr const char* plan_name = "plan.toml";
constexpr const char* chunks_name = "chunks";
constexpr std::uint64_t most_shards = 1'000'000;

void write_file(const fs::path& path, std::string_view text) {
  files::OutputFile file(path.string());
  file.write(text);
  file.commit();
}

/// What another process that begins at the same time may have made already.
bool may_be_ours(const std::string& name) {
  return name == plan_name || name == chunks_name || name == identity_name ||
         name.starts_with("lock-") || name.ends_with(".part");
}

void check_identity(const Campaign& campaign, const std::string& path) {
  const Identity there = identity_of(files::whole_file((fs::path(path) / identity_name).string()));
  const std::string different = differences(there, campaign.plan.identity);
  if (!different.empty()) {
    throw files::UserError(fmt::format(
        "{}: holds the results of another plan than {}: {}. Choose another folder for --out, or "
        "run what the folder was begun with",
        path, campaign.plan.path, different));
  }
}

hal::Descriptor lock_file(const std::string& path) {
  hal::Descriptor file(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (file.number() < 0) {
    throw files::UserError(fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));
  }
  return file;
}

bool has_identity(const std::string& path) {
  std::error_code ignored;
  return fs::exists(fs::path(path) / identity_name, ignored);
}

}  // namespace

Shard shard_of(const std::string& text) {
  Shard shard{};
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, shard.index);
  const bool divided = first.ec == std::errc{} && first.ptr != end && *first.ptr == '/';
  const auto second = std::from_chars(divided ? first.ptr + 1 : end, end, shard.count);
  if (!divided || second.ec != std::errc{} || second.ptr != end || shard.count < 1 ||
      shard.count > most_shards || shard.index >= shard.count) {
    throw files::UserError(fmt::format(
        "--shard {}: must be K/N, such as 0/4: part K, from 0 to N-1, of N parts, at most {}", text,
        most_shards));
  }
  return shard;
}

Folder Folder::existing(const Campaign& campaign, const std::string& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    throw files::UserError(fmt::format("--out {}: there is no such folder", path));
  }
  if (!has_identity(path)) {
    throw files::UserError(fmt::format("--out {}: is not the folder of a campaign: it has no {}",
                                       path, identity_name));
  }
  check_identity(campaign, path);
  return Folder(path);
}

Folder Folder::prepared(const Campaign& campaign, const std::string& path) {
  files::prepare_folder("--out", path);
  if (!has_identity(path)) {
    for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
      const std::string name = entry.path().filename().string();
      if (!may_be_ours(name)) {
        throw files::UserError(fmt::format(
            "--out {}: holds other files, such as {}; give a new or an empty folder", path, name));
      }
    }
  }
  Folder folder(path);
  files::prepare_folder("--out", (fs::path(path) / chunks_name).string());
  if (!has_identity(path)) {
    // Of two plans that begin at the same time, the second one finds the first one's identity.
    const hal::Descriptor held = lock_file((fs::path(path) / "lock-begin").string());
    flock(held.number(), LOCK_EX);
    if (!has_identity(path)) {
      write_file(fs::path(path) / plan_name, campaign.plan.text);
      write_file(fs::path(path) / identity_name, identity_text(campaign.plan));
    }
  }
  // At any moment since the first look another one may have written it.
  check_identity(campaign, path);
  return folder;
}

std::string Folder::chunk_path(std::uint64_t number) const {
  return (fs::path(path_) / chunks_name / fmt::format("{:06}.csv", number)).string();
}

std::string Folder::trials_path() const {
  return (fs::path(path_) / "trials.csv").string();
}

std::string Folder::file_path(const std::string& name) const {
  const fs::path folder = fs::path(path_) / "files";
  files::prepare_folder("--out", folder.string());
  return (folder / name).string();
}

std::vector<std::string> Folder::strangers(const Campaign& campaign) const {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(path_) / chunks_name)) {
    const std::string name = entry.path().filename().string();
    std::uint64_t number = 0;
    const auto read = std::from_chars(name.data(), name.data() + name.size(), number);
    const bool ours = read.ec == std::errc{} && number < campaign.plan.chunks() &&
                      name == fmt::format("{:06}.csv", number);
    if (!ours && !name.ends_with(".part")) {
      names.push_back(name);
    }
  }
  std::ranges::sort(names);
  return names;
}

void Folder::remove_left_overs(const Shard& shard) const {
  files::remove_left_overs((fs::path(path_) / chunks_name).string(), [&](const std::string& name) {
    std::uint64_t number = 0;
    const auto read = std::from_chars(name.data(), name.data() + name.size(), number);
    return read.ec == std::errc{} && number % shard.count == shard.index &&
           name.starts_with(fmt::format("{:06}.csv.", number));
  });
}

hal::Descriptor Folder::lock(const Shard& shard) const {
  const std::string path =
      (fs::path(path_) / fmt::format("lock-{}-of-{}", shard.index, shard.count)).string();
  hal::Descriptor file = lock_file(path);
  if (flock(file.number(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    throw files::UserError(
        fmt::format("{}: is in use: another process computes shard {}/{} of it; wait for it, or "
                    "give --shard",
                    path_, shard.index, shard.count));
  }
  return file;
}

}  // namespace smaservo::campaign
