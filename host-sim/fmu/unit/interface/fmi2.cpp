// FMI 2.0 for co-simulation.

#include "host-sim/fmu/unit/interface/fmi2.h"

#include <memory>

#include "host-sim/fmu/unit/interface/guarded.hpp"

namespace smaservo::fmu::unit {
namespace {

/// What a fmi2Component points to.
struct Slave {
  std::string name;
  fmi2CallbackLogger logger;
  fmi2ComponentEnvironment environment;
  double start_s;
  std::unique_ptr<Instance> instance;
};

void tell(fmi2CallbackLogger logger, fmi2ComponentEnvironment environment, const std::string& name,
          const std::string& problem) {
  if (logger != nullptr) {
    // The message goes in as a value, since a logger takes its text for a format.
    logger(environment, name.c_str(), fmi2Error, "logStatusError", "%s", problem.c_str());
  }
}

/// Runs f(slave), which returns what is wrong or "".
template <class F>
fmi2Status guarded2(fmi2Component c, F f) {
  if (c == nullptr) {
    return fmi2Error;
  }
  Slave& slave = *static_cast<Slave*>(c);
  const std::string problem = problem_of([&] { return f(slave); });
  if (problem.empty()) {
    return fmi2OK;
  }
  tell(slave.logger, slave.environment, slave.name, problem);
  return fmi2Error;
}

fmi2Status not_offered(fmi2Component c, const char* what) {
  return guarded2(c, [&](Slave&) { return std::string(what) + " is not offered by this FMU"; });
}

template <class Value>
fmi2Status get2(fmi2Component c, Type type, const fmi2ValueReference* references, std::size_t count,
                Value* values) {
  return guarded2(c, [&](Slave& slave) {
    return get_all(*slave.instance, type, true, references, count, values);
  });
}

template <class Value>
fmi2Status set2(fmi2Component c, Type type, const fmi2ValueReference* references, std::size_t count,
                const Value* values) {
  return guarded2(c, [&](Slave& slave) {
    return set_all(*slave.instance, type, true, references, count, values);
  });
}

/// Steps are complete when fmi2DoStep returns, so there is no status to ask for but this one.
fmi2Status no_status(fmi2Component c) {
  const fmi2Status status = not_offered(c, "a pending step");
  return status == fmi2Error && c != nullptr ? fmi2Discard : status;
}

}  // namespace
}  // namespace smaservo::fmu::unit

// NOLINTBEGIN(readability-identifier-naming): the standard's names
using namespace smaservo::fmu::unit;  // NOLINT(google-build-using-namespace): what follows is C's

const char* fmi2GetTypesPlatform() {
  return "default";
}
const char* fmi2GetVersion() {
  return "2.0";
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean /*on*/, size_t /*count*/,
                               const fmi2String* /*categories*/) {
  // Errors alone are told, and these always.
  return c == nullptr ? fmi2Error : fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                              fmi2String resource_location, const fmi2CallbackFunctions* functions,
                              fmi2Boolean /*visible*/, fmi2Boolean /*logging*/) {
  const fmi2CallbackLogger logger = functions == nullptr ? nullptr : functions->logger;
  void* const environment = functions == nullptr ? nullptr : functions->componentEnvironment;
  std::unique_ptr<Slave> slave;
  const std::string problem = problem_of([&]() -> std::string {
    if (type != fmi2CoSimulation) {
      return "this FMU is for co-simulation";
    }
    if (name == nullptr || *name == '\0' || guid == nullptr || resource_location == nullptr) {
      return "name, GUID or location of the resources is missing";
    }
    slave = std::make_unique<Slave>(
        Slave{name, logger, environment, 0, std::make_unique<Instance>(guid, resource_location)});
    return "";
  });
  if (!problem.empty()) {
    tell(logger, environment, name == nullptr ? "" : name, problem);
    return nullptr;
  }
  return slave.release();
}

void fmi2FreeInstance(fmi2Component c) {
  delete static_cast<Slave*>(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean /*has_tolerance*/,
                               fmi2Real /*tolerance*/, fmi2Real start_s, fmi2Boolean /*has_stop*/,
                               fmi2Real /*stop_s*/) {
  return guarded2(c, [&](Slave& slave) -> std::string {
    if (slave.instance->stage() != Stage::instantiated) {
      return "fmi2SetupExperiment is allowed before initialization alone";
    }
    slave.start_s = start_s;
    return "";
  });
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  return guarded2(c,
                  [](Slave& slave) { return slave.instance->enter_initialization(slave.start_s); });
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  return guarded2(c, [](Slave& slave) { return slave.instance->exit_initialization(); });
}
fmi2Status fmi2Terminate(fmi2Component c) {
  return guarded2(c, [](Slave& slave) { return slave.instance->terminate(); });
}
fmi2Status fmi2Reset(fmi2Component c) {
  return guarded2(c, [](Slave& slave) {
    slave.start_s = 0;
    return slave.instance->start_over();
  });
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t count,
                       fmi2Real values[]) {
  return get2(c, Type::real, references, count, values);
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference references[], size_t count,
                          fmi2Integer values[]) {
  return get2(c, Type::whole, references, count, values);
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference references[], size_t count,
                          fmi2Boolean values[]) {
  return get2(c, Type::flag, references, count, values);
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference /*references*/[], size_t count,
                         fmi2String /*values*/[]) {
  return count == 0 && c != nullptr ? fmi2OK : not_offered(c, "a variable with a text");
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t count,
                       const fmi2Real values[]) {
  return set2(c, Type::real, references, count, values);
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference references[], size_t count,
                          const fmi2Integer values[]) {
  return set2(c, Type::whole, references, count, values);
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference references[], size_t count,
                          const fmi2Boolean values[]) {
  return guarded2(c, [&](Slave& slave) -> std::string {
    if (count > 0 && values == nullptr) {
      return "the values are missing";
    }
    // C has no other numbers for true and false; some simulators take any number but 0 for true.
    std::vector<fmi2Boolean> flags(values, values + count);
    for (fmi2Boolean& flag : flags) {
      flag = flag != fmi2False ? fmi2True : fmi2False;
    }
    return set_all(*slave.instance, Type::flag, true, references, count, flags.data());
  });
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference /*references*/[], size_t count,
                         const fmi2String /*values*/[]) {
  return count == 0 && c != nullptr ? fmi2OK : not_offered(c, "a variable with a text");
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return guarded2(c, [&](Slave& slave) { return save_state(*slave.instance, state); });
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  return guarded2(c, [&](Slave& slave) { return restore_state(*slave.instance, state); });
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
  free_state(state);
  return c == nullptr ? fmi2Error : fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
  return guarded2(c, [&](Slave&) { return size_of_state(state, size); });
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],
                                 size_t size) {
  return guarded2(c, [&](Slave&) { return write_state(state, bytes, size); });
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate* state) {
  return guarded2(c, [&](Slave& slave) { return read_state(*slave.instance, bytes, size, state); });
}
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference /*unknowns*/[],
                                        size_t /*unknown_count*/,
                                        const fmi2ValueReference /*knowns*/[],
                                        size_t /*known_count*/, const fmi2Real /*known_changes*/[],
                                        fmi2Real /*unknown_changes*/[]) {
  return not_offered(c, "a directional derivative");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference /*references*/[],
                                       size_t /*count*/, const fmi2Integer /*orders*/[],
                                       const fmi2Real /*values*/[]) {
  return not_offered(c, "interpolation of inputs");
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference /*references*/[],
                                        size_t /*count*/, const fmi2Integer /*orders*/[],
                                        fmi2Real /*values*/[]) {
  return not_offered(c, "a derivative of an output");
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real from_s, fmi2Real step_s,
                      fmi2Boolean /*no_return_before*/) {
  return guarded2(c, [&](Slave& slave) { return slave.instance->step(from_s, step_s); });
}
fmi2Status fmi2CancelStep(fmi2Component c) {
  return not_offered(c, "a pending step");
}
fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind /*kind*/, fmi2Status* /*value*/) {
  return no_status(c);
}
fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real* value) {
  if (kind != fmi2LastSuccessfulTime) {
    return no_status(c);
  }
  return guarded2(c, [&](Slave& slave) -> std::string {
    if (value == nullptr) {
      return "there is no place for the time";
    }
    *value = slave.instance->time_s();
    return "";
  });
}
fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind /*kind*/, fmi2Integer* /*value*/) {
  return no_status(c);
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean* value) {
  if (kind != fmi2Terminated || c == nullptr || value == nullptr) {
    return no_status(c);
  }
  *value = fmi2False;  // this FMU never ends a simulation by itself
  return fmi2OK;
}
fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind /*kind*/, fmi2String* /*value*/) {
  return no_status(c);
}
// NOLINTEND(readability-identifier-naming)
