#pragma once
// What ends a program with a message.

#include <stdexcept>

namespace smaservo::files {

/// The root of all errors of this project: a message for a person, which names what and where.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A mistake of the user's or the machine's that a message explains; ends the program with 1.
class UserError : public Error {
 public:
  using Error::Error;
};

/// One that only a person mends, in a file or an option: to try again changes nothing.
class ConfigError : public UserError {
 public:
  using UserError::UserError;
};

/// What was asked has been done, and its result is one that nobody can use: no valid resistance, a
/// fit that has not converged, observers that are all lost, a recording that ended early; ends the
/// program with 3.
class NoResult : public Error {
 public:
  using Error::Error;
};

}  // namespace smaservo::files
