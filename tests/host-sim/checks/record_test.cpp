#include "host-sim/checks/record.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "host-sim/checks/findings.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test {
namespace {

constexpr Geometry<double> wire{0.1, 76e-6};

checks::Record record_of(const std::string& text, std::size_t most) {
  const TemporaryFolder folder;
  hal::TraceReader trace(folder.write("t.csv", text), {});
  checks::Recorder recorder(trace, most);
  hal::TraceRow row{};
  while (trace.next(row)) {
    recorder.add(row);
  }
  return recorder.finish("t.csv", wire);
}

// Whole blocks of rows, from the beginning to the end, whatever the length.
TEST(Recorder, KeepsBlocksOfLongTraces) {
  constexpr std::size_t block = 256, most = 1024;
  std::string text = "time_ms,current_mA,voltage_V,load_N\n";
  for (std::size_t rows = 1; rows <= 20'000; ++rows) {
    text += std::to_string(rows) + ",100,2,0.5\n";
    if (rows != 1000 && rows != 1024 && rows != 1025 && rows != 5000 && rows != 20'000) {
      continue;
    }
    const checks::Record record = record_of(text, most);
    const std::size_t kept = record.time_s.size();
    ASSERT_LE(kept, most);
    ASSERT_GE(kept, std::min(rows, most / 2));
    ASSERT_EQ(record.lines.size(), kept);
    const auto stride = static_cast<std::size_t>(
        kept > block ? (record.lines[block] - record.lines[0]) / block : 1);
    for (std::size_t i = 0; i < kept; ++i) {
      const std::size_t row = i / block * block * stride + i % block;
      ASSERT_EQ(record.lines[i], row + 2) << rows;
      ASSERT_DOUBLE_EQ(record.time_s[i], 1e-3 * static_cast<double>(row + 1));
    }
    EXPECT_GE(record.lines.back() + block * stride, rows) << "to the end";
  }
}

TEST(Recorder, KnowsWhereColumnsStand) {
  const checks::Record record = record_of("note,t [ms],I [mA],U [V]\na,0,100,2\nb,1,0,0\n", 1024);
  EXPECT_EQ(record.column(hal::Column::current, "none"), "column 3 'I [mA]'");
  EXPECT_EQ(record.column(hal::Column::load, "none"), "none");
  EXPECT_EQ(record.row(1), "line 3");
  EXPECT_DOUBLE_EQ(record.resistance_ohm[0], 20);
  EXPECT_TRUE(std::isnan(record.resistance_ohm[1])) << "no current";
}

// A file may lack any column, or its reader may not understand one. 40 rows of a wire that is
// heated have no mistake, and what is left of them has none that the missing columns would have
// shown.
TEST(Findings, NeedNoColumn) {
  struct Column {
    const char* name;
    double cold, hot;
  };
  const std::vector<Column> columns{{"current_A", 0.02, 0.12},
                                    {"voltage_V", 0.49, 2.6},
                                    {"load_N", 0.68, 0.68},
                                    {"displacement_mm", 0, 3},
                                    {"temperature_degC", 25, 120}};
  for (unsigned kept = 0; kept < 1U << columns.size(); ++kept) {
    std::string text = "time_s";
    for (std::size_t c = 0; c < columns.size(); ++c) {
      text += (kept >> c & 1U) != 0 ? "," + std::string(columns[c].name) : "";
    }
    for (int row = 0; row < 40; ++row) {
      text += "\n" + std::to_string(row);
      for (std::size_t c = 0; c < columns.size(); ++c) {
        const double share = 0.5 - 0.5 * std::cos(0.3 * row);
        text += (kept >> c & 1U) != 0
                    ? "," + std::to_string(std::lerp(columns[c].cold, columns[c].hot, share))
                    : "";
      }
    }
    checks::Record record = record_of(text + "\n", 1024);
    for (const auto kind :
         {checks::RunKind::joule, checks::RunKind::settled, checks::RunKind::bath}) {
      record.kind = kind;
      for (const checks::Finding& finding : checks::find_mistakes(record, {wire})) {
        EXPECT_FALSE(finding.is_error && finding.check == "direction")
            << kept << ": " << finding.text;
      }
    }
  }
}

}  // namespace
}  // namespace smaservo::test
