#pragma once
// MCAP files in memory: made of CSV text, and read back.

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "hal/recording/mcap/rows_reader.hpp"
#include "hal/recording/mcap/rows_writer.hpp"
#include "model/files/error.hpp"

namespace smaservo::test {

namespace mcap = hal::mcap;

inline std::string to_mcap(std::string_view csv, bool compressed = true,
                           std::vector<mcap::Kind> kinds = {}) {
  mcap::RowsWriter writer({"test", "memory"}, std::move(kinds), compressed);
  writer.add(csv);
  writer.finish();
  return writer.take();
}

/// Gives the bytes in pieces of up to `piece`.
inline mcap::Reader::Source source_of(std::string_view bytes, std::size_t piece = 1U << 20U) {
  return [bytes, piece](char* to, std::size_t size) mutable {
    const std::size_t part = bytes.copy(to, std::min(size, piece));
    bytes.remove_prefix(part);
    return part;
  };
}

struct Read {
  std::string csv;      ///< header and rows
  std::string problem;  ///< why it has ended before its time
  std::string cut_off;

  bool operator==(const Read&) const = default;
};

inline Read read_mcap(std::string_view bytes, std::size_t piece = 1U << 20U,
                      const std::string& topic = "") {
  Read read;
  try {
    mcap::RowsReader rows(source_of(bytes, piece), topic);
    read.csv = rows.header() + '\n';
    while (rows.next(read.csv)) {
      read.csv += '\n';
    }
    read.cut_off = rows.cut_off();
  } catch (const files::UserError& error) {
    read.problem = error.what();
  }
  return read;
}

}  // namespace smaservo::test
