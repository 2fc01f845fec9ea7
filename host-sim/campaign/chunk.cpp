#include "host-sim/campaign/chunk.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fmt/format.h>

#include "host-sim/hash.hpp"
#include "model/files/input_file.hpp"

namespace smaservo::campaign {
namespace {

constexpr std::string_view end_mark = "# end: ";
/// "# file 123 name": the next 123 bytes are the file, then comes an end of line.
constexpr std::string_view attached_mark = "# file ";

std::string chunk_head(const Campaign& campaign, std::uint64_t number) {
  const Plan& plan = campaign.plan;
  return fmt::format("# smaservo {}\n# plan {}\n# kind {}\n# chunk {}: trials {} to {}\n{}",
                     plan.version, plan.fingerprint, plan.kind, number, plan.first(number),
                     plan.first(number + 1) - 1, csv_head(campaign.trials->columns()));
}

std::string chunk_end(std::uint64_t rows, std::string_view before) {
  return fmt::format("{}{} rows, checksum {}\n", end_mark, rows, hash_of(before));
}

std::string_view line_at(std::string_view text, std::size_t begin) {
  return text.substr(begin, text.find('\n', begin) - begin);
}

/// Names the first line of the head that is not as it should be.
std::string other_head(std::string_view text, std::string_view head) {
  const auto differs = std::ranges::mismatch(text, head);
  const auto at = static_cast<std::size_t>(differs.in2 - head.begin());
  const std::size_t before = at == 0 ? std::string_view::npos : head.rfind('\n', at - 1);
  const std::size_t begin = before == std::string_view::npos ? 0 : before + 1;
  return fmt::format(R"(is not of this plan: it has "{}" where "{}" is wanted)",
                     line_at(text, begin), line_at(head, begin));
}

}  // namespace

std::vector<TrialFile> ChunkFile::files() const {
  std::vector<TrialFile> all;
  std::string_view rest = std::string_view(text).substr(end);
  while (rest.starts_with(attached_mark)) {
    rest.remove_prefix(attached_mark.size());
    std::size_t size = 0;
    const auto number = std::from_chars(rest.data(), rest.data() + rest.size(), size);
    rest.remove_prefix(static_cast<std::size_t>(number.ptr - rest.data()) + 1);
    const std::string_view name = line_at(rest, 0);
    rest.remove_prefix(name.size() + 1);
    all.push_back({std::string(name), std::string(rest.substr(0, size))});
    rest.remove_prefix(size + 1);
  }
  return all;
}

std::string chunk_text(const Campaign& campaign, std::uint64_t number,
                       const std::vector<TrialResult>& results) {
  std::string text = chunk_head(campaign, number);
  std::uint64_t trial = campaign.plan.first(number);
  for (const TrialResult& result : results) {
    text += csv_line(trial++, result.row);
  }
  for (const TrialResult& result : results) {
    for (const TrialFile& file : result.files) {
      text += fmt::format("{}{} {}\n{}\n", attached_mark, file.text.size(), file.name, file.text);
    }
  }
  return text + chunk_end(results.size(), text);
}

ChunkFile read_chunk(const Campaign& campaign, std::uint64_t number, const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    return {ChunkState::missing, "is missing", {}};
  }
  ChunkFile file{ChunkState::broken, {}, files::whole_file(path)};
  const std::string_view text = file.text;
  const std::size_t last =
      text.size() < 2 ? std::string_view::npos : text.rfind('\n', text.size() - 2);
  if (last == std::string_view::npos || !text.ends_with('\n') ||
      !text.substr(last + 1).starts_with(end_mark)) {
    file.problem = "is cut off: its last line is not that of a whole chunk";
    return file;
  }
  const std::string_view before = text.substr(0, last + 1);
  const std::string head = chunk_head(campaign, number);
  const std::uint64_t wanted = campaign.plan.first(number + 1) - campaign.plan.first(number);
  file.begin = std::min(head.size(), before.size());
  // Rows begin with a number.
  const std::size_t mark = before.find('\n' + std::string(attached_mark), file.begin - 1);
  file.end = mark == std::string_view::npos ? before.size() : mark + 1;
  const auto rows = static_cast<std::uint64_t>(std::ranges::count(file.rows(), '\n'));
  if (!text.substr(last + 1).ends_with(fmt::format("checksum {}\n", hash_of(before)))) {
    file.problem = "has been changed: its checksum is another one";
  } else if (!before.starts_with(head)) {
    file.state = ChunkState::foreign;
    file.problem = other_head(before, head);
  } else if (rows != wanted || text.substr(last + 1) != chunk_end(wanted, before)) {
    file.problem = fmt::format("has {} rows, not {}", rows, wanted);
  } else {
    file.state = ChunkState::whole;
  }
  return file;
}

}  // namespace smaservo::campaign
