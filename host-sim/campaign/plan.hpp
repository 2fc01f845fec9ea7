#pragma once
// The plan of a campaign: a TOML file, whose keys are in README.md.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host-sim/campaign/trials.hpp"
#include "model/files/toml/toml_table.hpp"

namespace smaservo::campaign {

/// Everything that the rows depend on, as pairs of a name and a value: the version, the plan's
/// keys, and the hashes of all files that it refers to.
using Identity = std::vector<std::pair<std::string, std::string>>;

struct Plan {
  std::string path;  ///< as it was given
  std::string text;  ///< the file's content
  std::string kind;
  std::uint64_t trials;  ///< while its kind is read, 0 if the plan does not say it
  std::uint64_t seed;
  std::uint64_t chunk;  ///< trials of a chunk; the last one may have fewer
  std::string version;  ///< of the program
  Identity identity;
  std::string fingerprint;  ///< hash of the identity

  std::uint64_t chunks() const { return (trials + chunk - 1) / chunk; }
  /// The first trial of a chunk. That of chunks() is the number of trials.
  std::uint64_t first(std::uint64_t number) const {
    return number < chunks() ? number * chunk : trials;
  }
};

/// A plan, and the trials that it describes.
struct Campaign {
  Plan plan;
  std::unique_ptr<const Trials> trials;
};

/// Reads the table of a kind. What it reads of other files becomes a part of the plan's identity.
class KindTable {
 public:
  KindTable(const Plan& plan, const files::TomlFile& file, files::TomlTable& table, Identity& found)
      : plan_(plan), file_(file), table_(table), found_(found) {}

  const Plan& plan() const { return plan_; }
  files::TomlTable& keys() { return table_; }
  /// A whole number. Throws ConfigError.
  std::uint64_t whole(std::string_view key, double low, double high, double otherwise);
  /// The path of the file or folder that this key names relative to the plan.
  std::string path(std::string_view key);
  /// Adds the content of a file that trials are computed from. `name` is relative to the plan.
  /// Returns its hash. Throws ConfigError, which names the key, if it cannot be read.
  std::string depends_on(std::string_view key, const std::string& name, const std::string& path);
  /// Adds a text that trials are computed from, such as settings that were read from several files.
  void depends_on_text(const std::string& name, std::string_view text);
  /// How many trials there are, where that follows from the files: a plan may have fewer, and need
  /// not say how many.
  void has_trials(std::uint64_t count) { trials_ = count; }
  std::uint64_t trials() const { return trials_; }

 private:
  const Plan& plan_;
  const files::TomlFile& file_;
  files::TomlTable& table_;
  Identity& found_;
  std::uint64_t trials_ = 0;
};

struct Kind {
  std::string_view name;
  std::unique_ptr<const Trials> (*read)(KindTable& table);
};

/// The version of this program.
std::string program_version();

/// Reads a plan and all that it refers to. Throws ConfigError, which names file, line, key, value
/// and what is allowed.
Campaign read_plan(const std::string& path, std::span<const Kind> kinds,
                   const std::string& version = program_version());

/// The first eight of many texts, and how many there are besides.
std::string some_of(const std::vector<std::string>& all, std::string_view separator);

/// What differs between two identities, for a person: "trials: 10, here 20; wires/a.toml: another
/// content".
std::string differences(const Identity& there, const Identity& here);

/// An identity as lines of text, and back. Lines that are none are left out.
std::string identity_text(const Plan& plan);
Identity identity_of(std::string_view text);

}  // namespace smaservo::campaign
