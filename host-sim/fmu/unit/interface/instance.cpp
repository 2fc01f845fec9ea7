#include "host-sim/fmu/unit/interface/instance.hpp"

#include <cmath>
#include <cstring>

#include "host-sim/fmu/unit/check.hpp"

namespace smaservo::fmu::unit {
namespace {

/// FNV-1a.
std::uint64_t hash_of(const unsigned char* bytes, std::size_t size) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (std::size_t i = 0; i < size; ++i) {
    hash = (hash ^ bytes[i]) * 0x100000001B3U;
  }
  return hash;
}

std::uint64_t hash_of(const std::string& text) {
  const std::vector<unsigned char> bytes(text.begin(), text.end());
  return hash_of(bytes.data(), bytes.size());
}

/// The head of a saved state. As a number it also tells the order of bytes.
constexpr std::uint64_t magic = 0x31554D4641414D53;

struct Head {
  std::uint64_t magic, identity, size;
  Stage stage;
  std::uint32_t stale;
  double start_s;
};

constexpr std::size_t checksum_size = sizeof(std::uint64_t);

const char* name_of(Stage stage) {
  constexpr const char* names[] = {"after instantiation", "in initialization mode", "in step mode",
                                   "after termination"};
  return names[static_cast<std::size_t>(stage)];
}

const char* name_of(Type type) {
  constexpr const char* names[] = {"a real", "an integer", "an enumeration", "a boolean"};
  return names[static_cast<std::size_t>(type)];
}

std::string not_allowed(const char* what, Stage stage) {
  return std::string(what) + " is not allowed " + name_of(stage);
}

}  // namespace

Instance::Instance(const std::string& token, const std::string& location) {
  Constants constants = read_constants(folder_of(location));
  if (constants.kind != component_kind()) {
    throw ConstantsError("the resources are of a " + constants.kind + ", this library is of a " +
                         component_kind());
  }
  if (constants.token != token) {
    throw ConstantsError("the token " + token + " is not that of the resources, " +
                         constants.token);
  }
  component_ = make_component(constants);
  constants.finish();
  if (constants.interface != interface_of(component_->variables())) {
    throw ConstantsError("the resources were written for another version of this library");
  }
  start_ = component_->values;
  // Saved states differ where the memory's layout does.
  identity_ = hash_of(token + std::to_string(component_->memory().size()));
}

std::string Instance::enter_initialization(double start_s) {
  if (stage_ != Stage::instantiated) {
    return not_allowed("initialization", stage_);
  }
  if (!std::isfinite(start_s)) {
    return "the start time is not finite";
  }
  start_s_ = start_s;
  component_->values[0] = start_s;
  stage_ = Stage::initializing;
  stale_ = true;
  return "";
}

std::string Instance::refresh() {
  if (!stale_) {
    return "";
  }
  std::string problem = component_->begin();
  stale_ = !problem.empty();
  return problem;
}

std::string Instance::exit_initialization() {
  if (stage_ != Stage::initializing) {
    return not_allowed("the end of initialization", stage_);
  }
  std::string problem = refresh();
  if (problem.empty()) {
    stage_ = Stage::running;
  }
  return problem;
}

std::string Instance::terminate() {
  if (stage_ != Stage::running) {
    return not_allowed("termination", stage_);
  }
  stage_ = Stage::terminated;
  return "";
}

std::string Instance::start_over() {
  component_->values = start_;
  // The start values were checked when they were read.
  std::string problem = component_->begin();
  component_->values = start_;
  stage_ = Stage::instantiated;
  start_s_ = 0;
  stale_ = true;
  return problem;
}

std::string Instance::step(double from_s, double step_s) {
  if (stage_ != Stage::running) {
    return not_allowed("a step", stage_);
  }
  if (!(0 < step_s && step_s <= longest_step_s)) {
    return "the step is " + shown(step_s) + " s long; allowed is more than 0, up to " +
           shown(longest_step_s) + " s";
  }
  // Simulators add up steps, each with an error of rounding.
  const double tolerance_s = 1e-9 * (1 + std::abs(time_s()));
  if (!(std::abs(from_s - time_s()) <= tolerance_s)) {
    return "the step begins at " + shown(from_s) + " s, the time is " + shown(time_s()) + " s";
  }
  const double to_s = from_s + step_s;
  std::string problem = component_->advance(to_s - start_s_, step_s);
  if (problem.empty()) {
    component_->values[0] = to_s;
  }
  return problem;
}

std::string Instance::wrong_reference(std::size_t reference, Type type,
                                      bool choice_is_whole) const {
  const std::vector<Variable>& all = component_->variables();
  if (reference >= all.size()) {
    return "there is no variable with the value reference " + std::to_string(reference);
  }
  const Type own = all[reference].type;
  if (own != type && !(choice_is_whole && own == Type::choice && type == Type::whole)) {
    return all[reference].name + " is " + name_of(own) + ", not " + name_of(type);
  }
  return "";
}

std::string Instance::get(std::size_t reference, Type type, bool choice_is_whole, double& value) {
  std::string problem = wrong_reference(reference, type, choice_is_whole);
  if (problem.empty() && stage_ == Stage::initializing &&
      component_->variables()[reference].role == Role::output) {
    problem = refresh();
  }
  if (problem.empty()) {
    value = component_->values[reference];
  }
  return problem;
}

std::string Instance::set(const std::vector<std::size_t>& references, Type type,
                          bool choice_is_whole, const std::vector<double>& values) {
  if (stage_ == Stage::terminated) {
    return not_allowed("to set a value", stage_);
  }
  const std::vector<Variable>& all = component_->variables();
  for (std::size_t i = 0; i < references.size(); ++i) {
    std::string problem = wrong_reference(references[i], type, choice_is_whole);
    if (!problem.empty()) {
      return problem;
    }
    const Variable& v = all[references[i]];
    if (v.role != Role::input && v.role != Role::parameter) {
      return v.name + " cannot be set";
    }
    if (v.role == Role::parameter && stage_ == Stage::running) {
      return v.name + " is fixed: it may be set until initialization ends";
    }
    // Ranges of parameters are checked together, when initialization ends.
    const bool input = v.role == Role::input;
    if (!std::isfinite(values[i])) {
      return v.name + " = " + shown(values[i]) + " is not finite";
    }
    problem = input ? wrong_value(v, values[i]) : "";
    if (!problem.empty()) {
      return problem;
    }
  }
  for (std::size_t i = 0; i < references.size(); ++i) {
    component_->values[references[i]] = values[i];
  }
  stale_ = stale_ || stage_ == Stage::initializing;
  return "";
}

Saved Instance::save() {
  const std::span<std::byte> memory = component_->memory();
  const std::vector<double>& values = component_->values;
  const std::size_t size =
      sizeof(Head) + values.size() * sizeof(double) + memory.size() + checksum_size;
  Head head{};
  head.magic = magic;
  head.identity = identity_;
  head.size = size;
  head.stage = stage_;
  head.stale = stale_ ? 1 : 0;
  head.start_s = start_s_;
  Saved saved(size);
  unsigned char* to = saved.data();
  const auto add = [&](const void* from, std::size_t bytes) {
    std::memcpy(to, from, bytes);
    to += bytes;
  };
  add(&head, sizeof head);
  add(values.data(), values.size() * sizeof(double));
  add(memory.data(), memory.size());
  const std::uint64_t checksum = hash_of(saved.data(), size - checksum_size);
  add(&checksum, checksum_size);
  return saved;
}

std::string Instance::check(const Saved& saved) const {
  const std::size_t size = sizeof(Head) + component_->values.size() * sizeof(double) +
                           component_->memory().size() + checksum_size;
  Head head{};
  if (saved.size() >= sizeof head) {
    std::memcpy(&head, saved.data(), sizeof head);
  }
  if (head.magic != magic) {
    return "the bytes are no saved state of this FMU";
  }
  if (head.identity != identity_) {
    return "the saved state is of another FMU";
  }
  if (saved.size() != size || head.size != size) {
    return "the saved state has " + std::to_string(saved.size()) + " bytes, not " +
           std::to_string(size) + ": it was cut off";
  }
  std::uint64_t checksum = 0;
  std::memcpy(&checksum, &saved[size - checksum_size], checksum_size);
  if (checksum != hash_of(saved.data(), size - checksum_size) || head.stage > Stage::terminated) {
    return "the saved state is damaged: its checksum is wrong";
  }
  return "";
}

std::string Instance::restore(const Saved& saved) {
  std::string problem = check(saved);
  if (!problem.empty()) {
    return problem;
  }
  Head head{};
  const unsigned char* from = saved.data();
  std::memcpy(&head, from, sizeof head);
  from += sizeof head;
  std::vector<double>& values = component_->values;
  std::memcpy(values.data(), from, values.size() * sizeof(double));
  from += values.size() * sizeof(double);
  const std::span<std::byte> memory = component_->memory();
  std::memcpy(memory.data(), from, memory.size());
  stage_ = head.stage;
  stale_ = head.stale != 0;
  start_s_ = head.start_s;
  if (!stale_) {
    component_->restored();
  }
  return "";
}

}  // namespace smaservo::fmu::unit
