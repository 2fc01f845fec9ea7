#pragma once
// The token that whoever connects from another machine needs, in a file that only its owner reads.

#include <string>

namespace smaservo::page {

/// A new token: 256 random bits as hexadecimal digits.
std::string random_token();

/// The token of a file, which is made with a random one where it is missing. Refuses a file that
/// others may read, and a token that can be guessed. Throws UserError.
std::string token_of(const std::string& path);

/// Where the token is kept unless an option says so: below $STATE_DIRECTORY (of a service),
/// $XDG_STATE_HOME or $HOME/.local/state. Throws ConfigError where none is set.
std::string default_token_file();

}  // namespace smaservo::page
