#pragma once
// What stands between C and the instance: nothing is thrown over the interface, and each problem is
// told to the simulator.

#include <exception>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "host-sim/fmu/unit/interface/instance.hpp"

namespace smaservo::fmu::unit {

/// Runs f(), which returns what is wrong or ""; an exception becomes a text, too.
template <class F>
std::string problem_of(F f) noexcept {
  try {
    try {
      return f();
    } catch (const std::exception& error) {
      return error.what();
    }
  } catch (...) {
    // The text of an error took the last memory: fits into the string itself.
    return "no memory";
  }
}

/// Reads the values of all references into `values`.
template <class Reference, class Value>
std::string get_all(Instance& instance, Type type, bool choice_is_whole,
                    const Reference* references, std::size_t count, Value* values) {
  if (count > 0 && (references == nullptr || values == nullptr)) {
    return "the values or their references are missing";
  }
  for (std::size_t i = 0; i < count; ++i) {
    double value = 0;
    std::string problem = instance.get(references[i], type, choice_is_whole, value);
    if (!problem.empty()) {
      return problem;
    }
    values[i] = static_cast<Value>(value);
  }
  return "";
}

/// Sets all of them or none.
template <class Reference, class Value>
std::string set_all(Instance& instance, Type type, bool choice_is_whole,
                    const Reference* references, std::size_t count, const Value* values) {
  if (count > 0 && (references == nullptr || values == nullptr)) {
    return "the values or their references are missing";
  }
  return instance.set(std::vector<std::size_t>(references, references + count), type,
                      choice_is_whole, std::vector<double>(values, values + count));
}

/// What an instance saves, restores and frees for a simulator, which holds a pointer to it.
inline std::string save_state(Instance& instance, void** state) {
  if (state == nullptr) {
    return "there is no place for the state";
  }
  Saved saved = instance.save();
  if (*state == nullptr) {
    *state = new Saved(std::move(saved));  // NOLINT(*-owning-memory): the simulator's
  } else {
    *static_cast<Saved*>(*state) = std::move(saved);
  }
  return "";
}

inline std::string restore_state(Instance& instance, const void* state) {
  return state == nullptr ? "there is no state"
                          : instance.restore(*static_cast<const Saved*>(state));
}

inline void free_state(void** state) {
  if (state != nullptr) {
    delete static_cast<Saved*>(*state);  // NOLINT(*-owning-memory)
    *state = nullptr;
  }
}

inline std::string size_of_state(const void* state, std::size_t* size) {
  if (state == nullptr || size == nullptr) {
    return "there is no state";
  }
  *size = static_cast<const Saved*>(state)->size();
  return "";
}

template <class Byte>
std::string write_state(const void* state, Byte* bytes, std::size_t size) {
  if (state == nullptr || bytes == nullptr) {
    return "there is no state";
  }
  const Saved& saved = *static_cast<const Saved*>(state);
  if (size < saved.size()) {
    return "the state needs " + std::to_string(saved.size()) + " bytes, there are " +
           std::to_string(size);
  }
  for (std::size_t i = 0; i < saved.size(); ++i) {
    bytes[i] = static_cast<Byte>(saved[i]);
  }
  return "";
}

template <class Byte>
std::string read_state(const Instance& instance, const Byte* bytes, std::size_t size,
                       void** state) {
  if (bytes == nullptr || state == nullptr) {
    return "there is no state";
  }
  Saved saved(size);
  for (std::size_t i = 0; i < size; ++i) {
    saved[i] = static_cast<unsigned char>(bytes[i]);
  }
  std::string problem = instance.check(saved);
  if (problem.empty()) {
    if (*state == nullptr) {
      *state = new Saved(std::move(saved));  // NOLINT(*-owning-memory): the simulator's
    } else {
      *static_cast<Saved*>(*state) = std::move(saved);
    }
  }
  return problem;
}

}  // namespace smaservo::fmu::unit
