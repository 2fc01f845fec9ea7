#pragma once
// FMUs as a simulator has them: exported by host-sim, unpacked, their library loaded.

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <dlfcn.h>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>
#include <zip.h>

#include "host-sim/fmu/fmu_file.hpp"
#include "host-sim/fmu/unit/interface/fmi2.h"
#include "host-sim/fmu/unit/interface/fmi3.h"
#include "model/files/installed.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::test {

/// Writes all files of the archive below the folder. Returns their names.
inline std::vector<std::string> unpack(const std::string& archive, const std::string& folder) {
  int code = 0;
  const std::unique_ptr<zip_t, void (*)(zip_t*)> zip(
      zip_open(archive.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, &code), zip_discard);
  if (!zip) {
    throw std::runtime_error(archive + " is no zip archive");
  }
  std::vector<std::string> names;
  for (zip_int64_t i = 0; i < zip_get_num_entries(zip.get(), 0); ++i) {
    const auto index = static_cast<zip_uint64_t>(i);
    zip_stat_t stat;
    zip_stat_index(zip.get(), index, 0, &stat);
    const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(
        zip_fopen_index(zip.get(), index, 0), zip_fclose);
    std::string content(stat.size, '\0');
    if (zip_fread(file.get(), content.data(), stat.size) != static_cast<zip_int64_t>(stat.size)) {
      throw std::runtime_error(std::string(stat.name) + " cannot be unpacked");
    }
    const std::filesystem::path path = std::filesystem::path(folder) / stat.name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << content;
    names.emplace_back(stat.name);
  }
  return names;
}

/// The part of an FMU that its library needs, in a folder of its own: FmuFile.IsWhatItsFolderHas
/// compares it with a whole one, which takes half a second to pack.
class FmuFolder {
 public:
  explicit FmuFolder(const fmu::ExportOptions& options)
      : description(fmu::describe(options)),
        version(options.version),
        token(fmu::token_of(description, version)) {
    std::filesystem::create_directories(resources());
    folder_.write("un packed%/resources/values.txt", fmu::values_file(description, version));
  }

  std::string resources() const { return folder_ / "un packed%/resources"; }
  std::string library() const { return library_of(description.kind); }
  static std::string library_of(fmu::Kind kind) {
#ifdef __x86_64__
    const char* const here = "x86_64-linux";
#else
    const char* const here = "aarch64-linux";
#endif
    return files::installed("fmu") / here / (fmu::identifier(kind) + ".so");
  }

  fmu::Description description;
  fmu::Version version;
  std::string token;

 private:
  TemporaryFolder folder_;
};

/// The functions of a library.
class FmuLibrary {
 public:
  explicit FmuLibrary(const std::string& path) : handle_(dlopen(path.c_str(), RTLD_NOW)) {
    if (handle_ == nullptr) {
      throw std::runtime_error(dlerror());
    }
  }
  ~FmuLibrary() { dlclose(handle_); }
  FmuLibrary(const FmuLibrary&) = delete;
  FmuLibrary& operator=(const FmuLibrary&) = delete;

  void* symbol(const char* name) const { return dlsym(handle_, name); }
  template <class F>
  F* function(const char* name) const {
    void* const found = symbol(name);
    if (found == nullptr) {
      throw std::runtime_error(std::string(name) + " is missing");
    }
    return reinterpret_cast<F*>(found);  // NOLINT(*-reinterpret-cast)
  }

 private:
  void* handle_;
};

/// What an instance has told.
struct FmuLog {
  std::vector<std::string> messages;
};

[[gnu::format(printf, 5, 6)]]
inline void log2(fmi2ComponentEnvironment log, fmi2String /*name*/, fmi2Status /*status*/,
                 fmi2String /*category*/, fmi2String format, ...) {
  va_list arguments;
  va_start(arguments, format);
  std::string text(2000, '\0');
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  text.resize(text.find('\0'));
  static_cast<FmuLog*>(log)->messages.push_back(text);
}

inline void log3(fmi3InstanceEnvironment log, fmi3Status /*status*/, fmi3String /*category*/,
                 fmi3String message) {
  static_cast<FmuLog*>(log)->messages.emplace_back(message);
}

/// An instance, driven by either version. Calls give "" or the message that was logged with an
/// error.
class Slave {
 public:
  explicit Slave(const FmuFolder& fmu) : Slave(fmu, fmu.token, fmu.resources()) {}
  Slave(const FmuFolder& fmu, const std::string& token, const std::string& resources)
      : library(fmu.library()), two_(fmu.version == fmu::Version::fmi2), fmu_(fmu) {
    if (two_) {
      callbacks_ = {log2, nullptr, nullptr, nullptr, &log};
      it = library.function<decltype(fmi2Instantiate)>("fmi2Instantiate")(
          "it", fmi2CoSimulation, token.c_str(), resources.c_str(), &callbacks_, 0, 0);
      free_instance_ = library.function<decltype(fmi2FreeInstance)>("fmi2FreeInstance");
    } else {
      it = library.function<decltype(fmi3InstantiateCoSimulation)>("fmi3InstantiateCoSimulation")(
          "it", token.c_str(), resources.c_str(), false, false, false, false, nullptr, 0, &log,
          log3, nullptr);
      free_instance_ = library.function<decltype(fmi3FreeInstance)>("fmi3FreeInstance");
    }
  }
  ~Slave() { free_instance_(it); }
  Slave(const Slave&) = delete;
  Slave& operator=(const Slave&) = delete;

  std::string enter(double start_s = 0) {
    time_s = start_s;
    if (!two_) {
      return said(library.function<decltype(fmi3EnterInitializationMode)>(
          "fmi3EnterInitializationMode")(it, false, 0, start_s, false, 0));
    }
    const std::string setup = said(library.function<decltype(fmi2SetupExperiment)>(
        "fmi2SetupExperiment")(it, 0, 0, start_s, 0, 0));
    return setup.empty() ? said(library.function<decltype(fmi2EnterInitializationMode)>(
                               "fmi2EnterInitializationMode")(it))
                         : setup;
  }
  std::string exit() {
    return said_of<decltype(fmi2ExitInitializationMode), decltype(fmi3ExitInitializationMode)>(
        "fmi2ExitInitializationMode", "fmi3ExitInitializationMode");
  }
  std::string begin(double start_s = 0) {
    const std::string entered = enter(start_s);
    return entered.empty() ? exit() : entered;
  }
  std::string terminate() {
    return said_of<decltype(fmi2Terminate), decltype(fmi3Terminate)>("fmi2Terminate",
                                                                     "fmi3Terminate");
  }
  std::string reset() {
    return said_of<decltype(fmi2Reset), decltype(fmi3Reset)>("fmi2Reset", "fmi3Reset");
  }

  std::string step_from(double from_s, double step_s) {
    if (two_) {
      return said(library.function<decltype(fmi2DoStep)>("fmi2DoStep")(it, from_s, step_s, 1));
    }
    bool event = true;
    bool terminate = true;
    bool early = true;
    double last_s = -1;
    const std::string text = said(library.function<decltype(fmi3DoStep)>("fmi3DoStep")(
        it, from_s, step_s, true, &event, &terminate, &early, &last_s));
    if (text.empty() && (event || terminate || early || last_s != from_s + step_s)) {
      throw std::runtime_error("fmi3DoStep did not make the whole step");
    }
    return text;
  }
  std::string step(double step_s) {
    std::string text = step_from(time_s, step_s);
    time_s += text.empty() ? step_s : 0;
    return text;
  }

  std::size_t reference(const std::string& name) const {
    const auto& all = fmu_.description.variables;
    const auto at = std::ranges::find(all, name, &fmu::unit::Variable::name);
    if (at == all.end()) {
      throw std::runtime_error("no variable " + name);
    }
    return static_cast<std::size_t>(at - all.begin());
  }

  std::string set(const std::string& name, double value) {
    const std::size_t at = reference(name);
    return set_reference(at, fmu_.description.variables[at].type, value);
  }
  std::string set_reference(std::size_t at, fmu::unit::Type type, double value) {
    const auto r = static_cast<unsigned>(at);
    const auto set_one = [&](auto* function, auto number) {
      if constexpr (requires { function(it, &r, 1, &number, 1); }) {
        return said(function(it, &r, 1, &number, 1));
      } else {
        return said(function(it, &r, 1, &number));
      }
    };
    const bool on = value != 0;
    switch (type) {
      case fmu::unit::Type::real:
        return two_ ? set_one(library.function<decltype(fmi2SetReal)>("fmi2SetReal"), value)
                    : set_one(library.function<decltype(fmi3SetFloat64)>("fmi3SetFloat64"), value);
      case fmu::unit::Type::flag:
        return two_ ? set_one(library.function<decltype(fmi2SetBoolean)>("fmi2SetBoolean"), int{on})
                    : set_one(library.function<decltype(fmi3SetBoolean)>("fmi3SetBoolean"), on);
      case fmu::unit::Type::choice:
        if (!two_) {
          return set_one(library.function<decltype(fmi3SetInt64)>("fmi3SetInt64"),
                         static_cast<std::int64_t>(value));
        }
        break;
      case fmu::unit::Type::whole:
        break;
    }
    const int number = static_cast<int>(value);
    return two_ ? set_one(library.function<decltype(fmi2SetInteger)>("fmi2SetInteger"), number)
                : set_one(library.function<decltype(fmi3SetInt32)>("fmi3SetInt32"), number);
  }

  double get(const std::string& name) {
    const std::size_t at = reference(name);
    double value = 0;
    const std::string text = get_reference(at, fmu_.description.variables[at].type, value);
    if (!text.empty()) {
      throw std::runtime_error(text);
    }
    return value;
  }
  std::string get_reference(std::size_t at, fmu::unit::Type type, double& value) {
    const auto r = static_cast<unsigned>(at);
    const auto get_one = [&](auto* function, auto number) {
      std::string text;
      if constexpr (requires { function(it, &r, 1, &number, 1); }) {
        text = said(function(it, &r, 1, &number, 1));
      } else {
        text = said(function(it, &r, 1, &number));
      }
      value = static_cast<double>(number);
      return text;
    };
    switch (type) {
      case fmu::unit::Type::real:
        return two_ ? get_one(library.function<decltype(fmi2GetReal)>("fmi2GetReal"), 0.0)
                    : get_one(library.function<decltype(fmi3GetFloat64)>("fmi3GetFloat64"), 0.0);
      case fmu::unit::Type::flag:
        return two_ ? get_one(library.function<decltype(fmi2GetBoolean)>("fmi2GetBoolean"), 0)
                    : get_one(library.function<decltype(fmi3GetBoolean)>("fmi3GetBoolean"), false);
      case fmu::unit::Type::choice:
        if (!two_) {
          return get_one(library.function<decltype(fmi3GetInt64)>("fmi3GetInt64"), std::int64_t{0});
        }
        break;
      case fmu::unit::Type::whole:
        break;
    }
    return two_ ? get_one(library.function<decltype(fmi2GetInteger)>("fmi2GetInteger"), 0)
                : get_one(library.function<decltype(fmi3GetInt32)>("fmi3GetInt32"), 0);
  }
  /// The values of all variables, for comparing.
  std::vector<double> all() {
    std::vector<double> values;
    for (std::size_t i = 0; i < fmu_.description.variables.size(); ++i) {
      double value = 0;
      const std::string text = get_reference(i, fmu_.description.variables[i].type, value);
      if (!text.empty()) {
        throw std::runtime_error(text);
      }
      values.push_back(value);
    }
    return values;
  }

  std::string save(void*& state) {
    return said_of<decltype(fmi2GetFMUstate), decltype(fmi3GetFMUState)>("fmi2GetFMUstate",
                                                                         "fmi3GetFMUState", &state);
  }
  std::string restore(void* state) {
    return said_of<decltype(fmi2SetFMUstate), decltype(fmi3SetFMUState)>("fmi2SetFMUstate",
                                                                         "fmi3SetFMUState", state);
  }
  std::string free(void*& state) {
    return said_of<decltype(fmi2FreeFMUstate), decltype(fmi3FreeFMUState)>(
        "fmi2FreeFMUstate", "fmi3FreeFMUState", &state);
  }
  std::vector<unsigned char> serialized(void* state) {
    std::size_t size = 0;
    said_of<decltype(fmi2SerializedFMUstateSize), decltype(fmi3SerializedFMUStateSize)>(
        "fmi2SerializedFMUstateSize", "fmi3SerializedFMUStateSize", state, &size);
    std::vector<unsigned char> bytes(size);
    if (two_) {
      said(library.function<decltype(fmi2SerializeFMUstate)>("fmi2SerializeFMUstate")(
          it, state, reinterpret_cast<char*>(bytes.data()), size));  // NOLINT(*-reinterpret-cast)
    } else {
      said(library.function<decltype(fmi3SerializeFMUState)>("fmi3SerializeFMUState")(
          it, state, bytes.data(), size));
    }
    return bytes;
  }
  std::string deserialize(const std::vector<unsigned char>& bytes, void*& state) {
    if (two_) {
      return said(library.function<decltype(fmi2DeSerializeFMUstate)>("fmi2DeSerializeFMUstate")(
          it, reinterpret_cast<const char*>(bytes.data()),  // NOLINT(*-reinterpret-cast)
          bytes.size(), &state));
    }
    return said(library.function<decltype(fmi3DeserializeFMUState)>("fmi3DeserializeFMUState")(
        it, bytes.data(), bytes.size(), &state));
  }

  FmuLibrary library;
  FmuLog log;
  void* it = nullptr;  ///< null: it could not be instantiated
  double time_s = 0;

  /// What a call has said, by its status.
  template <class Status>
  std::string said(Status status) {
    if (static_cast<int>(status) == 0) {
      return "";
    }
    const std::string text =
        log.messages.empty() ? "an error without a message" : log.messages.back();
    log.messages.clear();
    return text;
  }

 private:
  template <class F2, class F3, class... A>
  std::string said_of(const char* name2, const char* name3, A... a) {
    return two_ ? said(library.function<F2>(name2)(it, a...))
                : said(library.function<F3>(name3)(it, a...));
  }

  bool two_;
  void (*free_instance_)(void*) = nullptr;
  const FmuFolder& fmu_;
  fmi2CallbackFunctions callbacks_{};
};

}  // namespace smaservo::test
