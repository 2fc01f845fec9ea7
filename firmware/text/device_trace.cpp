#include "firmware/text/device_trace.hpp"

#include <array>
#include <charconv>
#include <cmath>

#include "firmware/text/device_names.hpp"

namespace smaservo {
namespace {

constexpr std::size_t buffer_size = std::size_t{1} << 18U;

template <auto of>
void number(std::string& to, const Turn& turn) {
  append_number(to, of(turn));
}
template <auto of>
void flag(std::string& to, const Turn& turn) {
  to += of(turn) ? '1' : '0';
}
template <auto of>
void text(std::string& to, const Turn& turn) {
  to += of(turn);
}
using T = const Turn&;
using Columns = std::vector<DeviceColumn>;

constexpr std::array outputs{
    DeviceColumn{"drive_current_A", number<[](T t) { return t.output.current_A; }>},
    DeviceColumn{"drive_voltage_V", number<[](T t) { return t.output.voltage_V; }>},
    DeviceColumn{"state", text<[](T t) { return state_name(t.output.state); }>},
    DeviceColumn{"mode", text<[](T t) { return mode_name(t.output.mode); }>},
    DeviceColumn{"setpoint", number<[](T t) { return t.output.setpoint; }>},
    DeviceColumn{"reference", number<[](T t) { return t.output.reference; }>},
    DeviceColumn{"power_W", number<[](T t) { return t.output.power_W; }>},
    DeviceColumn{"strain", number<[](T t) { return t.output.estimate.strain; }>},
    DeviceColumn{"strain_sd", number<[](T t) { return t.output.estimate.strain_sd; }>},
    DeviceColumn{"wire_K", number<[](T t) { return t.output.estimate.temperature_K; }>},
    DeviceColumn{"martensite", number<[](T t) { return t.output.estimate.martensite; }>},
    DeviceColumn{"r_phase", number<[](T t) { return t.output.estimate.r_phase; }>},
    DeviceColumn{"health", text<[](T t) { return health_name(t.output.estimate.health); }>},
    DeviceColumn{"hot_spot_K", number<[](T t) { return t.output.hot_spot_K; }>},
    DeviceColumn{"believed_ambient_K", number<[](T t) { return t.output.ambient_K; }>},
    DeviceColumn{"limit_reasons",
                 text<[](T t) { return limit_reason_names(t.output.limit_reasons); }>},
    DeviceColumn{"active_faults", text<[](T t) { return names_of(t.output.active); }>},
    DeviceColumn{"latched_faults", text<[](T t) { return names_of(t.output.latched); }>},
    DeviceColumn{"first_cause", text<[](T t) { return fault_name(t.output.first_cause); }>},
    DeviceColumn{"warnings", text<[](T t) { return names_of(t.output.warnings); }>},
    DeviceColumn{"blocks", text<[](T t) { return names_of(t.output.blocks); }>},
};

constexpr std::array truths{
    DeviceColumn{"strain_ref", number<[](T t) { return t.truth.strain; }>},
    DeviceColumn{"hottest_K", number<[](T t) { return t.truth.hottest_K; }>},
    DeviceColumn{"true_current_A", number<[](T t) { return t.truth.current_A; }>},
    DeviceColumn{"true_stress_Pa", number<[](T t) { return t.truth.stress_Pa; }>},
};

}  // namespace

void append_number(std::string& to, double value) {
  if (std::isnan(value)) {
    return;
  }
  std::array<char, 32> digits{};
  char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  to.append(digits.data(), end);
}

Columns log_columns(bool supply, bool ambient, bool driver) {
  Columns all{
      {"time_s", number<[](T t) { return t.time_s; }>},
      {"fresh", flag<[](T t) { return t.inputs.fresh; }>},
      {"sequence", number<[](T t) { return static_cast<double>(t.inputs.sequence); }>},
      {"current_A", number<[](T t) { return t.inputs.sample.current_A; }>},
      {"voltage_V", number<[](T t) { return t.inputs.sample.voltage_V; }>},
      {"load_N", number<[](T t) { return t.inputs.sample.load_N; }>},
  };
  if (supply) {
    all.push_back({"supply_V", number<[](T t) { return t.inputs.supply_V; }>});
  }
  if (ambient) {
    all.push_back({"ambient_K", number<[](T t) { return t.inputs.ambient_K; }>});
  }
  if (driver) {
    all.push_back({"driver_K", number<[](T t) { return t.inputs.driver_K; }>});
  }
  const Columns rest{
      {"emergency_stop", flag<[](T t) { return t.inputs.emergency_stop; }>},
      {"driver_fault", flag<[](T t) { return t.inputs.driver_fault; }>},
      {"deadline_missed", flag<[](T t) { return t.inputs.deadline_missed; }>},
      {"external_faults", text<[](T t) { return names_of(t.inputs.external); }>},
      {"command_fresh", flag<[](T t) { return t.command.fresh; }>},
      {"command_arm", flag<[](T t) { return t.command.arm; }>},
      {"command_clear", flag<[](T t) { return t.command.clear_faults; }>},
      {"command_mode", text<[](T t) { return mode_name(t.command.mode); }>},
      {"command_setpoint", number<[](T t) { return t.command.setpoint; }>},
      {"command_proportional", number<[](T t) { return t.command.scale.proportional; }>},
      {"command_integral", number<[](T t) { return t.command.scale.integral; }>},
      {"command_derivative", number<[](T t) { return t.command.scale.derivative; }>},
  };
  all.insert(all.end(), rest.begin(), rest.end());
  return all;
}

std::span<const DeviceColumn> output_columns() {
  return outputs;
}
std::span<const DeviceColumn> truth_columns() {
  return truths;
}

DeviceRows::DeviceRows(Columns columns, const std::vector<std::string>& further)
    : columns_(std::move(columns)) {
  for (const DeviceColumn& column : columns_) {
    header_ += header_.empty() ? "" : ",";
    header_ += column.name;
  }
  for (const std::string& name : further) {
    header_ += ',' + name;
  }
  header_ += '\n';
}

void DeviceRows::append(std::string& to, const Turn& turn, std::string_view further) const {
  bool first = true;
  for (const DeviceColumn& column : columns_) {
    if (!first) {
      to += ',';
    }
    first = false;
    column.write(to, turn);
  }
  to += further;
  to += '\n';
}

DeviceTraceFile::DeviceTraceFile(const std::string& path, Columns columns,
                                 const std::vector<std::string>& further)
    : file_(path), rows_(std::move(columns), further), buffer_(rows_.header()) {
  buffer_.reserve(2 * buffer_size);
}

void DeviceTraceFile::add(const Turn& turn, std::string_view further) {
  rows_.append(buffer_, turn, further);
  if (buffer_.size() >= buffer_size) {
    file_.write(buffer_);
    buffer_.clear();
  }
}

void DeviceTraceFile::commit() {
  file_.write(buffer_);
  buffer_.clear();
  file_.commit();
}

}  // namespace smaservo
