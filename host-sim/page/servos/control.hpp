#pragma once
// Keeps which client may write, and which axes it has enabled. One client at a time has control.
// Every function may be called from any thread; none blocks.

#include <bitset>
#include <mutex>
#include <optional>
#include <string>

#include "host-sim/page/source.hpp"

namespace smaservo::page {

/// Set of node-ids, 1 to 127.
using NodeSet = std::bitset<128>;

inline constexpr const char* read_only_refusal =
    "nothing can be changed here: the page is read-only (--read-only)";

class Control {
 public:
  /// The permission under which a write was requested. It is in force until control passes to
  /// another client, or all is stopped.
  using Ticket = std::uint64_t;

  /// The result of a request to write. If nobody has control, the client gets it. `refusal` is
  /// empty, or the reason why the client may not write.
  struct Leave {
    Ticket ticket;
    std::string refusal;
  };
  Leave ask(const Caller& caller);

  /// Each of these ends all tickets and returns the axes that must be switched off at once.
  NodeSet take(std::uint32_t client);
  NodeSet give_up(std::uint32_t client);
  NodeSet stop_all();

  /// Notes that the axis is about to be heated under the ticket. False if the ticket is not in
  /// force any more.
  bool heat(Ticket ticket, unsigned node);
  /// Notes that the axis is off.
  void cooled(unsigned node);

  bool holds(Ticket ticket) const;
  std::optional<std::uint32_t> client() const;
  NodeSet heated() const;

 private:
  NodeSet end_tickets();

  mutable std::mutex mutex_;
  std::optional<std::uint32_t> client_;
  Ticket ticket_ = 1;
  NodeSet heated_;
};

}  // namespace smaservo::page
