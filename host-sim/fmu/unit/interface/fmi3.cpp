// FMI 3.0 for co-simulation, without event mode, early return and intermediate updates.

#include "host-sim/fmu/unit/interface/fmi3.h"

#include <memory>

#include "host-sim/fmu/unit/interface/guarded.hpp"

namespace smaservo::fmu::unit {
namespace {

/// What a fmi3Instance points to.
struct Slave3 {
  fmi3LogMessageCallback log;
  fmi3InstanceEnvironment environment;
  std::unique_ptr<Instance> instance;
};

void tell3(fmi3LogMessageCallback log, fmi3InstanceEnvironment environment,
           const std::string& problem) {
  if (log != nullptr) {
    log(environment, fmi3Error, "logStatusError", problem.c_str());
  }
}

/// Runs f(slave), which returns what is wrong or "".
template <class F>
fmi3Status guarded3(fmi3Instance i, F f) {
  if (i == nullptr) {
    return fmi3Error;
  }
  Slave3& slave = *static_cast<Slave3*>(i);
  const std::string problem = problem_of([&] { return f(slave); });
  if (problem.empty()) {
    return fmi3OK;
  }
  tell3(slave.log, slave.environment, problem);
  return fmi3Error;
}

fmi3Status not_offered3(fmi3Instance i, const char* what) {
  return guarded3(i, [&](Slave3&) { return std::string(what) + " is not offered by this FMU"; });
}

/// For a type of which there is no variable: nothing is wrong with none.
fmi3Status without3(fmi3Instance i, std::size_t count, const char* what) {
  return count == 0 && i != nullptr ? fmi3OK : not_offered3(i, what);
}

fmi3Instance no_instance(fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
  tell3(log, environment, "this FMU is for co-simulation");
  return nullptr;
}

const char* wrong_count(std::size_t references, std::size_t values) {
  return references == values ? "" : "there must be one value for each value reference";
}

template <class Value>
fmi3Status get3(fmi3Instance i, Type type, const fmi3ValueReference* references,
                std::size_t reference_count, Value* values, std::size_t count) {
  return guarded3(i, [&](Slave3& slave) {
    const std::string problem = wrong_count(reference_count, count);
    return problem.empty() ? get_all(*slave.instance, type, false, references, count, values)
                           : problem;
  });
}

template <class Value>
fmi3Status set3(fmi3Instance i, Type type, const fmi3ValueReference* references,
                std::size_t reference_count, const Value* values, std::size_t count) {
  return guarded3(i, [&](Slave3& slave) {
    const std::string problem = wrong_count(reference_count, count);
    return problem.empty() ? set_all(*slave.instance, type, false, references, count, values)
                           : problem;
  });
}

}  // namespace
}  // namespace smaservo::fmu::unit

// NOLINTBEGIN(readability-identifier-naming): the standard's names
using namespace smaservo::fmu::unit;  // NOLINT(google-build-using-namespace): what follows is C's

const char* fmi3GetVersion() {
  return "3.0";
}
fmi3Status fmi3SetDebugLogging(fmi3Instance i, fmi3Boolean /*on*/, size_t /*count*/,
                               const fmi3String /*categories*/[]) {
  // Errors alone are told, and these always.
  return i == nullptr ? fmi3Error : fmi3OK;
}
fmi3Instance fmi3InstantiateModelExchange(fmi3String /*name*/, fmi3String /*token*/,
                                          fmi3String /*resource_path*/, fmi3Boolean /*visible*/,
                                          fmi3Boolean /*logging*/,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
  return no_instance(environment, log);
}
fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resource_path, fmi3Boolean /*visible*/,
    fmi3Boolean /*logging*/, fmi3Boolean event_mode, fmi3Boolean /*early_return*/,
    const fmi3ValueReference /*intermediates*/[], size_t intermediate_count,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3IntermediateUpdateCallback /*update*/) {
  std::unique_ptr<Slave3> slave;
  const std::string problem = problem_of([&]() -> std::string {
    if (event_mode || intermediate_count > 0) {
      return "this FMU has neither event mode nor intermediate updates";
    }
    if (name == nullptr || token == nullptr || resource_path == nullptr) {
      return "name, token or path of the resources is missing";
    }
    slave = std::make_unique<Slave3>(
        Slave3{log, environment, std::make_unique<Instance>(token, resource_path)});
    return "";
  });
  if (!problem.empty()) {
    tell3(log, environment, problem);
    return nullptr;
  }
  return slave.release();
}
fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String /*name*/, fmi3String /*token*/, fmi3String /*resource_path*/,
    fmi3Boolean /*visible*/, fmi3Boolean /*logging*/, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log, fmi3ClockUpdateCallback /*clock_update*/,
    fmi3LockPreemptionCallback /*lock*/, fmi3UnlockPreemptionCallback /*unlock*/) {
  return no_instance(environment, log);
}
void fmi3FreeInstance(fmi3Instance i) {
  delete static_cast<Slave3*>(i);
}
fmi3Status fmi3EnterInitializationMode(fmi3Instance i, fmi3Boolean /*has_tolerance*/,
                                       fmi3Float64 /*tolerance*/, fmi3Float64 start_s,
                                       fmi3Boolean /*has_stop*/, fmi3Float64 /*stop_s*/) {
  return guarded3(i, [&](Slave3& slave) { return slave.instance->enter_initialization(start_s); });
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance i) {
  return guarded3(i, [](Slave3& slave) { return slave.instance->exit_initialization(); });
}
fmi3Status fmi3EnterEventMode(fmi3Instance i) {
  return not_offered3(i, "event mode");
}
fmi3Status fmi3Terminate(fmi3Instance i) {
  return guarded3(i, [](Slave3& slave) { return slave.instance->terminate(); });
}
fmi3Status fmi3Reset(fmi3Instance i) {
  return guarded3(i, [](Slave3& slave) { return slave.instance->start_over(); });
}
fmi3Status fmi3GetFloat32(fmi3Instance i, const fmi3ValueReference /*references*/[],
                          size_t reference_count, fmi3Float32 /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type Float32");
}
fmi3Status fmi3GetFloat64(fmi3Instance i, const fmi3ValueReference references[],
                          size_t reference_count, fmi3Float64 values[], size_t count) {
  return get3(i, Type::real, references, reference_count, values, count);
}
fmi3Status fmi3GetInt8(fmi3Instance i, const fmi3ValueReference /*references*/[],
                       size_t reference_count, fmi3Int8 /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type Int8");
}
fmi3Status fmi3GetUInt8(fmi3Instance i, const fmi3ValueReference /*references*/[],
                        size_t reference_count, fmi3UInt8 /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type UInt8");
}
fmi3Status fmi3GetInt16(fmi3Instance i, const fmi3ValueReference /*references*/[],
                        size_t reference_count, fmi3Int16 /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type Int16");
}
fmi3Status fmi3GetUInt16(fmi3Instance i, const fmi3ValueReference /*references*/[],
                         size_t reference_count, fmi3UInt16 /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type UInt16");
}
fmi3Status fmi3GetInt32(fmi3Instance i, const fmi3ValueReference references[],
                        size_t reference_count, fmi3Int32 values[], size_t count) {
  return get3(i, Type::whole, references, reference_count, values, count);
}
fmi3Status fmi3GetUInt32(fmi3Instance i, const fmi3ValueReference /*references*/[],
                         size_t reference_count, fmi3UInt32 /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type UInt32");
}
fmi3Status fmi3GetInt64(fmi3Instance i, const fmi3ValueReference references[],
                        size_t reference_count, fmi3Int64 values[], size_t count) {
  return get3(i, Type::choice, references, reference_count, values, count);
}
fmi3Status fmi3GetUInt64(fmi3Instance i, const fmi3ValueReference /*references*/[],
                         size_t reference_count, fmi3UInt64 /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type UInt64");
}
fmi3Status fmi3GetBoolean(fmi3Instance i, const fmi3ValueReference references[],
                          size_t reference_count, fmi3Boolean values[], size_t count) {
  return get3(i, Type::flag, references, reference_count, values, count);
}
fmi3Status fmi3GetString(fmi3Instance i, const fmi3ValueReference /*references*/[],
                         size_t reference_count, fmi3String /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type String");
}
fmi3Status fmi3GetBinary(fmi3Instance i, const fmi3ValueReference /*references*/[],
                         size_t reference_count, size_t /*sizes*/[], fmi3Binary /*values*/[],
                         size_t /*count*/) {
  return without3(i, reference_count, "a variable of type Binary");
}
fmi3Status fmi3GetClock(fmi3Instance i, const fmi3ValueReference /*references*/[],
                        size_t reference_count, fmi3Clock /*values*/[]) {
  return without3(i, reference_count, "a clock");
}
fmi3Status fmi3SetFloat32(fmi3Instance i, const fmi3ValueReference /*references*/[],
                          size_t reference_count, const fmi3Float32 /*values*/[],
                          size_t /*count*/) {
  return without3(i, reference_count, "a variable of type Float32");
}
fmi3Status fmi3SetFloat64(fmi3Instance i, const fmi3ValueReference references[],
                          size_t reference_count, const fmi3Float64 values[], size_t count) {
  return set3(i, Type::real, references, reference_count, values, count);
}
fmi3Status fmi3SetInt8(fmi3Instance i, const fmi3ValueReference /*references*/[],
                       size_t reference_count, const fmi3Int8 /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type Int8");
}
fmi3Status fmi3SetUInt8(fmi3Instance i, const fmi3ValueReference /*references*/[],
                        size_t reference_count, const fmi3UInt8 /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type UInt8");
}
fmi3Status fmi3SetInt16(fmi3Instance i, const fmi3ValueReference /*references*/[],
                        size_t reference_count, const fmi3Int16 /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type Int16");
}
fmi3Status fmi3SetUInt16(fmi3Instance i, const fmi3ValueReference /*references*/[],
                         size_t reference_count, const fmi3UInt16 /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type UInt16");
}
fmi3Status fmi3SetInt32(fmi3Instance i, const fmi3ValueReference references[],
                        size_t reference_count, const fmi3Int32 values[], size_t count) {
  return set3(i, Type::whole, references, reference_count, values, count);
}
fmi3Status fmi3SetUInt32(fmi3Instance i, const fmi3ValueReference /*references*/[],
                         size_t reference_count, const fmi3UInt32 /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type UInt32");
}
fmi3Status fmi3SetInt64(fmi3Instance i, const fmi3ValueReference references[],
                        size_t reference_count, const fmi3Int64 values[], size_t count) {
  return set3(i, Type::choice, references, reference_count, values, count);
}
fmi3Status fmi3SetUInt64(fmi3Instance i, const fmi3ValueReference /*references*/[],
                         size_t reference_count, const fmi3UInt64 /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type UInt64");
}
fmi3Status fmi3SetBoolean(fmi3Instance i, const fmi3ValueReference references[],
                          size_t reference_count, const fmi3Boolean values[], size_t count) {
  return set3(i, Type::flag, references, reference_count, values, count);
}
fmi3Status fmi3SetString(fmi3Instance i, const fmi3ValueReference /*references*/[],
                         size_t reference_count, const fmi3String /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type String");
}
fmi3Status fmi3SetBinary(fmi3Instance i, const fmi3ValueReference /*references*/[],
                         size_t reference_count, const size_t /*sizes*/[],
                         const fmi3Binary /*values*/[], size_t /*count*/) {
  return without3(i, reference_count, "a variable of type Binary");
}
fmi3Status fmi3SetClock(fmi3Instance i, const fmi3ValueReference /*references*/[],
                        size_t reference_count, const fmi3Clock /*values*/[]) {
  return without3(i, reference_count, "a clock");
}
fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance i, fmi3ValueReference /*reference*/,
                                               size_t* /*count*/) {
  return not_offered3(i, "dependencies of elements");
}
fmi3Status fmi3GetVariableDependencies(fmi3Instance i, fmi3ValueReference /*dependent*/,
                                       size_t /*dependent_elements*/[],
                                       fmi3ValueReference /*independents*/[],
                                       size_t /*independent_elements*/[],
                                       fmi3DependencyKind /*kinds*/[], size_t /*count*/) {
  return not_offered3(i, "dependencies of elements");
}
fmi3Status fmi3GetFMUState(fmi3Instance i, fmi3FMUState* state) {
  return guarded3(i, [&](Slave3& slave) { return save_state(*slave.instance, state); });
}
fmi3Status fmi3SetFMUState(fmi3Instance i, fmi3FMUState state) {
  return guarded3(i, [&](Slave3& slave) { return restore_state(*slave.instance, state); });
}
fmi3Status fmi3FreeFMUState(fmi3Instance i, fmi3FMUState* state) {
  free_state(state);
  return i == nullptr ? fmi3Error : fmi3OK;
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance i, fmi3FMUState state, size_t* size) {
  return guarded3(i, [&](Slave3&) { return size_of_state(state, size); });
}
fmi3Status fmi3SerializeFMUState(fmi3Instance i, fmi3FMUState state, fmi3Byte bytes[],
                                 size_t size) {
  return guarded3(i, [&](Slave3&) { return write_state(state, bytes, size); });
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance i, const fmi3Byte bytes[], size_t size,
                                   fmi3FMUState* state) {
  return guarded3(i,
                  [&](Slave3& slave) { return read_state(*slave.instance, bytes, size, state); });
}
fmi3Status fmi3GetDirectionalDerivative(fmi3Instance i, const fmi3ValueReference /*unknowns*/[],
                                        size_t /*unknown_count*/,
                                        const fmi3ValueReference /*knowns*/[],
                                        size_t /*known_count*/, const fmi3Float64 /*seed*/[],
                                        size_t /*seed_count*/, fmi3Float64 /*sensitivity*/[],
                                        size_t /*sensitivity_count*/) {
  return not_offered3(i, "a directional derivative");
}
fmi3Status fmi3GetAdjointDerivative(fmi3Instance i, const fmi3ValueReference /*unknowns*/[],
                                    size_t /*unknown_count*/, const fmi3ValueReference /*knowns*/[],
                                    size_t /*known_count*/, const fmi3Float64 /*seed*/[],
                                    size_t /*seed_count*/, fmi3Float64 /*sensitivity*/[],
                                    size_t /*sensitivity_count*/) {
  return not_offered3(i, "an adjoint derivative");
}
fmi3Status fmi3EnterConfigurationMode(fmi3Instance i) {
  return not_offered3(i, "configuration mode");
}
fmi3Status fmi3ExitConfigurationMode(fmi3Instance i) {
  return not_offered3(i, "configuration mode");
}
fmi3Status fmi3GetIntervalDecimal(fmi3Instance i, const fmi3ValueReference /*references*/[],
                                  size_t /*reference_count*/, fmi3Float64 /*intervals*/[],
                                  fmi3IntervalQualifier /*qualifiers*/[]) {
  return not_offered3(i, "a clock");
}
fmi3Status fmi3GetIntervalFraction(fmi3Instance i, const fmi3ValueReference /*references*/[],
                                   size_t /*reference_count*/, fmi3UInt64 /*counters*/[],
                                   fmi3UInt64 /*resolutions*/[],
                                   fmi3IntervalQualifier /*qualifiers*/[]) {
  return not_offered3(i, "a clock");
}
fmi3Status fmi3GetShiftDecimal(fmi3Instance i, const fmi3ValueReference /*references*/[],
                               size_t /*reference_count*/, fmi3Float64 /*shifts*/[]) {
  return not_offered3(i, "a clock");
}
fmi3Status fmi3GetShiftFraction(fmi3Instance i, const fmi3ValueReference /*references*/[],
                                size_t /*reference_count*/, fmi3UInt64 /*counters*/[],
                                fmi3UInt64 /*resolutions*/[]) {
  return not_offered3(i, "a clock");
}
fmi3Status fmi3SetIntervalDecimal(fmi3Instance i, const fmi3ValueReference /*references*/[],
                                  size_t /*reference_count*/, const fmi3Float64 /*intervals*/[]) {
  return not_offered3(i, "a clock");
}
fmi3Status fmi3SetIntervalFraction(fmi3Instance i, const fmi3ValueReference /*references*/[],
                                   size_t /*reference_count*/, const fmi3UInt64 /*counters*/[],
                                   const fmi3UInt64 /*resolutions*/[]) {
  return not_offered3(i, "a clock");
}
fmi3Status fmi3SetShiftDecimal(fmi3Instance i, const fmi3ValueReference /*references*/[],
                               size_t /*reference_count*/, const fmi3Float64 /*shifts*/[]) {
  return not_offered3(i, "a clock");
}
fmi3Status fmi3SetShiftFraction(fmi3Instance i, const fmi3ValueReference /*references*/[],
                                size_t /*reference_count*/, const fmi3UInt64 /*counters*/[],
                                const fmi3UInt64 /*resolutions*/[]) {
  return not_offered3(i, "a clock");
}
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance i) {
  return not_offered3(i, "event mode");
}
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance i, fmi3Boolean* /*need_update*/,
                                    fmi3Boolean* /*terminate*/, fmi3Boolean* /*nominals_changed*/,
                                    fmi3Boolean* /*states_changed*/,
                                    fmi3Boolean* /*has_next_event*/,
                                    fmi3Float64* /*next_event_s*/) {
  return not_offered3(i, "event mode");
}
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance i) {
  return not_offered3(i, "model exchange");
}
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance i, fmi3Boolean /*no_return_before*/,
                                       fmi3Boolean* /*enter_event_mode*/,
                                       fmi3Boolean* /*terminate*/) {
  return not_offered3(i, "model exchange");
}
fmi3Status fmi3SetTime(fmi3Instance i, fmi3Float64 /*time_s*/) {
  return not_offered3(i, "model exchange");
}
fmi3Status fmi3SetContinuousStates(fmi3Instance i, const fmi3Float64 /*states*/[],
                                   size_t /*count*/) {
  return not_offered3(i, "model exchange");
}
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance i, fmi3Float64 /*derivatives*/[],
                                             size_t /*count*/) {
  return not_offered3(i, "model exchange");
}
fmi3Status fmi3GetEventIndicators(fmi3Instance i, fmi3Float64 /*indicators*/[], size_t /*count*/) {
  return not_offered3(i, "model exchange");
}
fmi3Status fmi3GetContinuousStates(fmi3Instance i, fmi3Float64 /*states*/[], size_t /*count*/) {
  return not_offered3(i, "model exchange");
}
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance i, fmi3Float64 /*nominals*/[],
                                             size_t /*count*/) {
  return not_offered3(i, "model exchange");
}
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance i, size_t* /*count*/) {
  return not_offered3(i, "model exchange");
}
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance i, size_t* /*count*/) {
  return not_offered3(i, "model exchange");
}
fmi3Status fmi3EnterStepMode(fmi3Instance i) {
  return not_offered3(i, "event mode");
}
fmi3Status fmi3GetOutputDerivatives(fmi3Instance i, const fmi3ValueReference /*references*/[],
                                    size_t /*reference_count*/, const fmi3Int32 /*orders*/[],
                                    fmi3Float64 /*values*/[], size_t /*count*/) {
  return not_offered3(i, "a derivative of an output");
}
// NOLINTBEGIN(readability-non-const-parameter): they are written
fmi3Status fmi3DoStep(fmi3Instance i, fmi3Float64 from_s, fmi3Float64 step_s,
                      fmi3Boolean /*no_return_before*/, fmi3Boolean* event_needed,
                      fmi3Boolean* terminate, fmi3Boolean* early_return, fmi3Float64* last_time_s) {
  return guarded3(i, [&](Slave3& slave) -> std::string {
    std::string problem = slave.instance->step(from_s, step_s);
    for (fmi3Boolean* const flag : {event_needed, terminate, early_return}) {
      if (flag != nullptr) {
        *flag = false;
      }
    }
    if (last_time_s != nullptr) {
      *last_time_s = slave.instance->time_s();
    }
    return problem;
  });
}
// NOLINTEND(readability-non-const-parameter)
fmi3Status fmi3ActivateModelPartition(fmi3Instance i, fmi3ValueReference /*clock*/,
                                      fmi3Float64 /*time_s*/) {
  return not_offered3(i, "scheduled execution");
}
// NOLINTEND(readability-identifier-naming)
