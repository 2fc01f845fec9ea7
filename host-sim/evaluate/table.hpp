#pragma once
// The table of an evaluation as text, JSON, Markdown and HTML.

#include <string>
#include <string_view>
#include <vector>

#include "host-sim/evaluate/evaluate.hpp"

namespace smaservo::evaluate {

std::string table_text(const Evaluation& evaluation);
std::string table_json(const Evaluation& evaluation);
/// One table for each observer; families are side by side.
std::string table_markdown(const Evaluation& evaluation);
/// Throws UserError.
void write_table_report(const std::string& path, const Evaluation& evaluation);

/// A Markdown file with a table between the lines that begin with "<!-- MARK:" and
/// "<!-- end of MARK -->".
class TableFile {
 public:
  /// Throws UserError if there is no such file, or no such line in it.
  explicit TableFile(std::string path, std::string_view mark = "evaluate");
  /// Replaces the table in the file as it is now: it may have been edited during an evaluation of
  /// hours. Throws UserError as the constructor, and leaves the file as it is then.
  void rewrite(const std::string& markdown) const;

 private:
  /// What stands before and after the table.
  struct Surroundings {
    std::string before, after;
  };
  Surroundings surroundings() const;

  std::string path_, mark_;
};

}  // namespace smaservo::evaluate
