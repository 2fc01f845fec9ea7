#include "host-sim/page/servos/control.hpp"

#include <fmt/format.h>
#include <utility>

namespace smaservo::page {

Control::Leave Control::ask(const Caller& caller) {
  if (caller.read_only) {
    return {0, read_only_refusal};
  }
  const std::scoped_lock lock(mutex_);
  if (!client_) {
    client_ = caller.client;
  }
  if (*client_ != caller.client) {
    return {0, fmt::format("client {} has control; take_control takes it", *client_)};
  }
  return {ticket_, ""};
}

NodeSet Control::end_tickets() {
  ++ticket_;
  return std::exchange(heated_, {});
}

NodeSet Control::take(std::uint32_t client) {
  const std::scoped_lock lock(mutex_);
  if (client_ == client) {
    return {};
  }
  client_ = client;
  return end_tickets();
}

NodeSet Control::give_up(std::uint32_t client) {
  const std::scoped_lock lock(mutex_);
  if (client_ != client) {
    return {};
  }
  client_.reset();
  return end_tickets();
}

NodeSet Control::stop_all() {
  const std::scoped_lock lock(mutex_);
  return end_tickets();
}

bool Control::heat(Ticket ticket, unsigned node) {
  const std::scoped_lock lock(mutex_);
  if (ticket != ticket_ || !client_) {
    return false;
  }
  heated_.set(node);
  return true;
}

void Control::cooled(unsigned node) {
  const std::scoped_lock lock(mutex_);
  heated_.reset(node);
}

bool Control::holds(Ticket ticket) const {
  const std::scoped_lock lock(mutex_);
  return ticket == ticket_ && client_.has_value();
}

std::optional<std::uint32_t> Control::client() const {
  const std::scoped_lock lock(mutex_);
  return client_;
}

NodeSet Control::heated() const {
  const std::scoped_lock lock(mutex_);
  return heated_;
}

}  // namespace smaservo::page
