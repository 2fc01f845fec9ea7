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
  void rewrite(const std::string& markdown) const;

 private:
  std::string path_, before_, after_;
};

}  // namespace smaservo::evaluate
