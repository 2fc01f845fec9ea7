#pragma once
// The table of an evaluation, in four shapes.

#include <string>
#include <vector>

#include "host-sim/evaluate/evaluate.hpp"

namespace smaservo {

std::string table_text(const Evaluation& evaluation);
std::string table_json(const Evaluation& evaluation);
/// One table for each observer; families side by side.
std::string table_markdown(const Evaluation& evaluation);
/// Throws UserError.
void write_table_report(const std::string& path, const Evaluation& evaluation);

/// Replaces what a Markdown file has between the lines that begin with "<!-- evaluate:" and
/// "<!-- end of evaluate -->". Throws UserError when there are none.
void rewrite_table(const std::string& path, const std::string& markdown);

}  // namespace smaservo
