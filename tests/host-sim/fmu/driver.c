/* driver LIBRARY VERSION TOKEN RESOURCES: a simulator in plain C. It loads the library of an FMU and carries out the
   lines of its standard input, in the order that the standard demands:

     set TYPE REFERENCE VALUE    TYPE is real, whole, choice or flag
     enter SECONDS               initialization mode, with the start time
     exit                        out of it
     step SECONDS
     get TYPE REFERENCE          prints the value with all its digits
     save, restore               the state
     end                         terminates and frees

   It ends with 1 at the first call that is refused, and prints what the FMU has logged. */
#include <dlfcn.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host-sim/fmu/unit/interface/fmi2.h"
#include "host-sim/fmu/unit/interface/fmi3.h"

static void *library;
static int two;
static void *instance;
static double now_s;

/* A pointer to an object becomes one to a function as POSIX has it. */
static void load(const char *name, void *function) {
  void *found = dlsym(library, name);
  if (found == NULL) {
    fprintf(stderr, "%s is missing\n", name);
    exit(1);
  }
  memcpy(function, &found, sizeof found);
}

#define LOADED(name) \
  __typeof__(&name) name##_; \
  load(#name, &name##_)

static void logged2(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                    fmi2String message, ...) {
  va_list arguments;
  (void)environment;
  fprintf(stderr, "%s: %d %s: ", name, (int)status, category);
  va_start(arguments, message);
  vfprintf(stderr, message, arguments);
  va_end(arguments);
  fputc('\n', stderr);
}

static void logged3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message) {
  (void)environment;
  fprintf(stderr, "%d %s: %s\n", (int)status, category, message);
}

static fmi2CallbackFunctions callbacks = {logged2, calloc, free, NULL, NULL};

static void check(int status, const char *what) {
  if (status != 0) {
    fprintf(stderr, "%s gave status %d\n", what, status);
    exit(1);
  }
}

static void set(const char *type, unsigned reference, double value) {
  if (strcmp(type, "real") == 0) {
    if (two) {
      LOADED(fmi2SetReal);
      check(fmi2SetReal_(instance, &reference, 1, &value), "SetReal");
    } else {
      LOADED(fmi3SetFloat64);
      check(fmi3SetFloat64_(instance, &reference, 1, &value, 1), "SetFloat64");
    }
  } else if (strcmp(type, "flag") == 0) {
    int flag = value != 0;
    bool flag3 = value != 0;
    if (two) {
      LOADED(fmi2SetBoolean);
      check(fmi2SetBoolean_(instance, &reference, 1, &flag), "SetBoolean");
    } else {
      LOADED(fmi3SetBoolean);
      check(fmi3SetBoolean_(instance, &reference, 1, &flag3, 1), "SetBoolean");
    }
  } else {
    int whole = (int)value;
    int64_t choice = (int64_t)value;
    if (two) {
      LOADED(fmi2SetInteger);
      check(fmi2SetInteger_(instance, &reference, 1, &whole), "SetInteger");
    } else if (strcmp(type, "choice") == 0) {
      LOADED(fmi3SetInt64);
      check(fmi3SetInt64_(instance, &reference, 1, &choice, 1), "SetInt64");
    } else {
      LOADED(fmi3SetInt32);
      check(fmi3SetInt32_(instance, &reference, 1, &whole, 1), "SetInt32");
    }
  }
}

static void get(const char *type, unsigned reference) {
  double real = 0;
  int whole = 0;
  int64_t choice = 0;
  bool flag = false;
  if (strcmp(type, "real") == 0) {
    if (two) {
      LOADED(fmi2GetReal);
      check(fmi2GetReal_(instance, &reference, 1, &real), "GetReal");
    } else {
      LOADED(fmi3GetFloat64);
      check(fmi3GetFloat64_(instance, &reference, 1, &real, 1), "GetFloat64");
    }
    printf("%.17g\n", real);
    return;
  }
  if (two && strcmp(type, "flag") == 0) {
    LOADED(fmi2GetBoolean);
    check(fmi2GetBoolean_(instance, &reference, 1, &whole), "GetBoolean");
    choice = whole;
  } else if (two) {
    LOADED(fmi2GetInteger);
    check(fmi2GetInteger_(instance, &reference, 1, &whole), "GetInteger");
    choice = whole;
  } else if (strcmp(type, "flag") == 0) {
    LOADED(fmi3GetBoolean);
    check(fmi3GetBoolean_(instance, &reference, 1, &flag, 1), "GetBoolean");
    choice = flag;
  } else if (strcmp(type, "choice") == 0) {
    LOADED(fmi3GetInt64);
    check(fmi3GetInt64_(instance, &reference, 1, &choice, 1), "GetInt64");
  } else {
    LOADED(fmi3GetInt32);
    check(fmi3GetInt32_(instance, &reference, 1, &whole, 1), "GetInt32");
    choice = whole;
  }
  printf("%" PRId64 "\n", choice);
}

static void enter(double start_s) {
  now_s = start_s;
  if (two) {
    LOADED(fmi2SetupExperiment);
    LOADED(fmi2EnterInitializationMode);
    check(fmi2SetupExperiment_(instance, fmi2False, 0, start_s, fmi2False, 0), "SetupExperiment");
    check(fmi2EnterInitializationMode_(instance), "EnterInitializationMode");
  } else {
    LOADED(fmi3EnterInitializationMode);
    check(fmi3EnterInitializationMode_(instance, false, 0, start_s, false, 0), "EnterInitializationMode");
  }
}

static void step(double step_s) {
  if (two) {
    LOADED(fmi2DoStep);
    check(fmi2DoStep_(instance, now_s, step_s, fmi2True), "DoStep");
  } else {
    bool event, terminate, early;
    double last_s;
    LOADED(fmi3DoStep);
    check(fmi3DoStep_(instance, now_s, step_s, true, &event, &terminate, &early, &last_s), "DoStep");
    check(event || terminate || early || last_s != now_s + step_s, "an early return");
  }
  now_s += step_s;
}

static void end(void) {
  if (two) {
    LOADED(fmi2Terminate);
    LOADED(fmi2FreeInstance);
    check(fmi2Terminate_(instance), "Terminate");
    fmi2FreeInstance_(instance);
  } else {
    LOADED(fmi3Terminate);
    LOADED(fmi3FreeInstance);
    check(fmi3Terminate_(instance), "Terminate");
    fmi3FreeInstance_(instance);
  }
}

static void *saved;
static double saved_s;

static void save(void) {
  saved_s = now_s;
  if (two) {
    LOADED(fmi2GetFMUstate);
    check(fmi2GetFMUstate_(instance, &saved), "GetFMUstate");
  } else {
    LOADED(fmi3GetFMUState);
    check(fmi3GetFMUState_(instance, &saved), "GetFMUState");
  }
}

static void restore(void) {
  now_s = saved_s;
  if (two) {
    LOADED(fmi2SetFMUstate);
    LOADED(fmi2FreeFMUstate);
    check(fmi2SetFMUstate_(instance, saved), "SetFMUstate");
    check(fmi2FreeFMUstate_(instance, &saved), "FreeFMUstate");
  } else {
    LOADED(fmi3SetFMUState);
    LOADED(fmi3FreeFMUState);
    check(fmi3SetFMUState_(instance, saved), "SetFMUState");
    check(fmi3FreeFMUState_(instance, &saved), "FreeFMUState");
  }
}

int main(int argc, char **argv) {
  char word[16], type[16];
  unsigned reference;
  double value;
  if (argc != 5) {
    fprintf(stderr, "usage: driver LIBRARY VERSION TOKEN RESOURCES\n");
    return 2;
  }
  library = dlopen(argv[1], RTLD_NOW);
  if (library == NULL) {
    fprintf(stderr, "%s\n", dlerror());
    return 1;
  }
  two = strcmp(argv[2], "2") == 0;
  if (two) {
    LOADED(fmi2Instantiate);
    instance = fmi2Instantiate_("driver", fmi2CoSimulation, argv[3], argv[4], &callbacks, fmi2False, fmi2False);
  } else {
    LOADED(fmi3InstantiateCoSimulation);
    instance = fmi3InstantiateCoSimulation_("driver", argv[3], argv[4], false, false, false, false, NULL, 0, NULL,
                                            logged3, NULL);
  }
  if (instance == NULL) {
    return 1;
  }
  while (scanf("%15s", word) == 1) {
    if (strcmp(word, "set") == 0 && scanf("%15s %u %lf", type, &reference, &value) == 3) {
      set(type, reference, value);
    } else if (strcmp(word, "get") == 0 && scanf("%15s %u", type, &reference) == 2) {
      get(type, reference);
    } else if (strcmp(word, "enter") == 0 && scanf("%lf", &value) == 1) {
      enter(value);
    } else if (strcmp(word, "exit") == 0 && two) {
      LOADED(fmi2ExitInitializationMode);
      check(fmi2ExitInitializationMode_(instance), "ExitInitializationMode");
    } else if (strcmp(word, "exit") == 0) {
      LOADED(fmi3ExitInitializationMode);
      check(fmi3ExitInitializationMode_(instance), "ExitInitializationMode");
    } else if (strcmp(word, "step") == 0 && scanf("%lf", &value) == 1) {
      step(value);
    } else if (strcmp(word, "save") == 0) {
      save();
    } else if (strcmp(word, "restore") == 0) {
      restore();
    } else if (strcmp(word, "end") == 0) {
      end();
      return dlclose(library) == 0 ? 0 : 1;
    } else {
      fprintf(stderr, "%s is not understood\n", word);
      return 2;
    }
  }
  return 2;
}
