#include "host-sim/replay/estimate_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "model/units.hpp"

namespace smaservo::replay {
namespace {

constexpr std::size_t estimate_buffer_size = std::size_t{1} << 18;
constexpr std::size_t longest_own_part = 512;
constexpr double exact = 9007199254740992.0;  // 2^53

constexpr std::array<std::string_view, 10> own_columns{
    "time_s",  "strain",    "strain_sd",      "wire_temperature_degC", "martensite",
    "r_phase", "austenite", "resistance_ohm", "resistance_model_ohm",  "valid"};

constexpr std::array<double, 10> powers{1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};

}  // namespace

char* append_fixed(char* to, double value, int decimals) {
  if (std::isnan(value)) {
    return to;
  }
  const double scaled = std::abs(value) * powers[static_cast<std::size_t>(decimals)];
  if (!(scaled < exact)) {
    return std::to_chars(to, to + 32, value).ptr;
  }
  auto digits = static_cast<std::uint64_t>(scaled);
  digits += scaled - static_cast<double>(digits) >= 0.5 ? 1 : 0;
  if (value < 0 && digits != 0) {
    *to++ = '-';
  }
  const auto unit = static_cast<std::uint64_t>(powers[static_cast<std::size_t>(decimals)]);
  to = std::to_chars(to, to + 24, digits / unit).ptr;
  if (decimals == 0) {
    return to;
  }
  *to = '.';
  std::uint64_t rest = digits % unit;
  for (int i = decimals; i > 0; --i) {
    to[i] = static_cast<char>('0' + rest % 10);
    rest /= 10;
  }
  return to + decimals + 1;
}

EstimateFile::EstimateFile(const std::string& path, const std::string& source, bool has_reference,
                           const std::vector<std::string>& passed,
                           std::vector<std::size_t> positions)
    : file_(path, {"host-sim replay", source},
            std::vector(own_columns.size() + (has_reference ? 1 : 0), hal::mcap::Kind::number)),
      has_reference_(has_reference),
      positions_(std::move(positions)),
      buffer_(estimate_buffer_size) {
  std::string header;
  for (const std::string_view name : own_columns) {
    header += header.empty() ? "" : ",";
    header += name;
  }
  header += has_reference ? ",strain_ref" : "";
  for (const std::string& name : passed) {
    const bool taken = std::ranges::find(own_columns, name) != own_columns.end() ||
                       (has_reference && name == "strain_ref");
    header += taken ? ",trace_" : ",";
    header += name;
  }
  file_.write(header + "\n");
}

void EstimateFile::add(const EstimateRow& row, std::string_view trace_row) {
  if (used_ + longest_own_part + trace_row.size() + positions_.size() > buffer_.size()) {
    file_.write({buffer_.data(), used_});
    used_ = 0;
    buffer_.resize(std::max(buffer_.size(), 2 * (longest_own_part + trace_row.size())));
  }
  char* to = buffer_.data() + used_;
  const auto field = [&](double value, int decimals) {
    *to++ = ',';
    to = append_fixed(to, value, decimals);
  };
  to = append_fixed(to, row.time_s, 6);
  field(row.strain, 7);
  field(row.strain_sd, 7);
  field(row.temperature_K - zero_degC_K, 3);
  field(row.martensite, 5);
  field(row.r_phase, 5);
  field(1 - row.martensite - row.r_phase, 5);
  field(row.resistance_ohm, 6);
  field(row.resistance_model_ohm, 6);
  *to++ = ',';
  *to++ = row.valid ? '1' : '0';
  if (has_reference_) {
    field(row.strain_ref, 7);
  }
  // The texts of the passed columns, in one walk along the row.
  std::size_t at = 0;
  std::size_t column = 0;
  for (const std::size_t position : positions_) {
    for (; column < position; ++column) {
      at = trace_row.find(',', at) + 1;
    }
    const std::size_t stop = std::min(trace_row.find(',', at), trace_row.size());
    *to++ = ',';
    std::memcpy(to, trace_row.data() + at, stop - at);
    to += stop - at;
  }
  *to++ = '\n';
  used_ = static_cast<std::size_t>(to - buffer_.data());
}

void EstimateFile::commit() {
  file_.write({buffer_.data(), used_});
  used_ = 0;
  file_.commit();
}

}  // namespace smaservo::replay
