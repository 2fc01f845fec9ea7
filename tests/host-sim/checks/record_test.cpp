#include "host-sim/checks/record.hpp"

#include <cmath>
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace smaservo::test
