/* The C interface of FMI 2.0 for co-simulation, as far as this project's FMUs have it: all
   functions of the standard for that interface type. Names and types are those of the standard
   (https://fmi-standard.org); the declarations are written for this project. */
#ifndef SMASERVO_FMI2_H
#define SMASERVO_FMI2_H

#include <stddef.h>

#ifdef _WIN32
#define SMASERVO_FMI2_EXPORT __declspec(dllexport)
#else
#define SMASERVO_FMI2_EXPORT __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(*-use-using, readability-identifier-naming): C, and the standard's names. */
typedef void* fmi2Component;
typedef void* fmi2ComponentEnvironment;
typedef void* fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Char;
typedef const fmi2Char* fmi2String;
typedef char fmi2Byte;

enum { fmi2False, fmi2True };

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum {
  fmi2DoStepStatus,
  fmi2PendingStatus,
  fmi2LastSuccessfulTime,
  fmi2Terminated
} fmi2StatusKind;

typedef void (*fmi2CallbackLogger)(fmi2ComponentEnvironment environment, fmi2String instance_name,
                                   fmi2Status status, fmi2String category, fmi2String message, ...);
typedef void* (*fmi2CallbackAllocateMemory)(size_t count, size_t size);
typedef void (*fmi2CallbackFreeMemory)(void* memory);
typedef void (*fmi2StepFinished)(fmi2ComponentEnvironment environment, fmi2Status status);

typedef struct {
  fmi2CallbackLogger logger;
  fmi2CallbackAllocateMemory allocateMemory;
  fmi2CallbackFreeMemory freeMemory;
  fmi2StepFinished stepFinished;
  fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

SMASERVO_FMI2_EXPORT const char* fmi2GetTypesPlatform(void);
SMASERVO_FMI2_EXPORT const char* fmi2GetVersion(void);
SMASERVO_FMI2_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count,
                                                    const fmi2String categories[]);
SMASERVO_FMI2_EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                                                   fmi2String resource_location,
                                                   const fmi2CallbackFunctions* functions,
                                                   fmi2Boolean visible, fmi2Boolean logging);
SMASERVO_FMI2_EXPORT void fmi2FreeInstance(fmi2Component c);
SMASERVO_FMI2_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance,
                                                    fmi2Real tolerance, fmi2Real start_s,
                                                    fmi2Boolean has_stop, fmi2Real stop_s);
SMASERVO_FMI2_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c);
SMASERVO_FMI2_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c);
SMASERVO_FMI2_EXPORT fmi2Status fmi2Terminate(fmi2Component c);
SMASERVO_FMI2_EXPORT fmi2Status fmi2Reset(fmi2Component c);

SMASERVO_FMI2_EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[],
                                            size_t count, fmi2Real values[]);
SMASERVO_FMI2_EXPORT fmi2Status fmi2GetInteger(fmi2Component c,
                                               const fmi2ValueReference references[], size_t count,
                                               fmi2Integer values[]);
SMASERVO_FMI2_EXPORT fmi2Status fmi2GetBoolean(fmi2Component c,
                                               const fmi2ValueReference references[], size_t count,
                                               fmi2Boolean values[]);
SMASERVO_FMI2_EXPORT fmi2Status fmi2GetString(fmi2Component c,
                                              const fmi2ValueReference references[], size_t count,
                                              fmi2String values[]);
SMASERVO_FMI2_EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[],
                                            size_t count, const fmi2Real values[]);
SMASERVO_FMI2_EXPORT fmi2Status fmi2SetInteger(fmi2Component c,
                                               const fmi2ValueReference references[], size_t count,
                                               const fmi2Integer values[]);
SMASERVO_FMI2_EXPORT fmi2Status fmi2SetBoolean(fmi2Component c,
                                               const fmi2ValueReference references[], size_t count,
                                               const fmi2Boolean values[]);
SMASERVO_FMI2_EXPORT fmi2Status fmi2SetString(fmi2Component c,
                                              const fmi2ValueReference references[], size_t count,
                                              const fmi2String values[]);

SMASERVO_FMI2_EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state);
SMASERVO_FMI2_EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state);
SMASERVO_FMI2_EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state);
SMASERVO_FMI2_EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state,
                                                           size_t* size);
SMASERVO_FMI2_EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state,
                                                      fmi2Byte bytes[], size_t size);
SMASERVO_FMI2_EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[],
                                                        size_t size, fmi2FMUstate* state);
SMASERVO_FMI2_EXPORT fmi2Status fmi2GetDirectionalDerivative(
    fmi2Component c, const fmi2ValueReference unknowns[], size_t unknown_count,
    const fmi2ValueReference knowns[], size_t known_count, const fmi2Real known_changes[],
    fmi2Real unknown_changes[]);

SMASERVO_FMI2_EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c,
                                                            const fmi2ValueReference references[],
                                                            size_t count,
                                                            const fmi2Integer orders[],
                                                            const fmi2Real values[]);
SMASERVO_FMI2_EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c,
                                                             const fmi2ValueReference references[],
                                                             size_t count,
                                                             const fmi2Integer orders[],
                                                             fmi2Real values[]);
SMASERVO_FMI2_EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real from_s, fmi2Real step_s,
                                           fmi2Boolean no_return_before);
SMASERVO_FMI2_EXPORT fmi2Status fmi2CancelStep(fmi2Component c);
SMASERVO_FMI2_EXPORT fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind kind,
                                              fmi2Status* value);
SMASERVO_FMI2_EXPORT fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind,
                                                  fmi2Real* value);
SMASERVO_FMI2_EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind kind,
                                                     fmi2Integer* value);
SMASERVO_FMI2_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind,
                                                     fmi2Boolean* value);
SMASERVO_FMI2_EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind kind,
                                                    fmi2String* value);
/* NOLINTEND(*-use-using, readability-identifier-naming) */

#ifdef __cplusplus
}
#endif

#endif
