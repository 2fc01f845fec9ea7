#pragma once
// What ends a program with a message.

#include <stdexcept>

namespace smaservo::files {

/// The root of all errors of this project: a message for a person, which names what and where.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A mistake of the user or a fault of the machine that a message explains; ends the program with
/// 1.
class UserError : public Error {
 public:
  using Error::Error;
};

/// An error that only a person can mend, in a file or an option: trying again changes nothing.
class ConfigError : public UserError {
 public:
  using UserError::UserError;
};

/// The program has done what was asked, but nobody can use the result: no valid resistance, a fit
/// that has not converged, observers that are all lost, a recording that ended early; ends the
/// program with 3.
class NoResult : public Error {
 public:
  using Error::Error;
};

}  // namespace smaservo::files
