#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/recording/mcap/rows_writer.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::hal {

/// Whether a file of this name is written as MCAP: it ends in .mcap.
bool is_mcap_name(std::string_view path);

/// A trace that a program writes as CSV text; if its name ends in .mcap, the file is MCAP. Like an
/// OutputFile it appears when it is complete. Throws UserError.
class TraceFile {
 public:
  /// `kinds` are the kinds of the columns, as for mcap::RowsWriter.
  TraceFile(const std::string& path, const mcap::Origin& origin,
            std::vector<mcap::Kind> kinds = {});

  void write(std::string_view csv);
  void commit();

 private:
  std::string path_;
  files::OutputFile file_;
  std::optional<mcap::RowsWriter> mcap_;
};

}  // namespace smaservo::hal
