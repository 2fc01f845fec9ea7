#include "host-sim/page/server/mailbox.hpp"

#include <utility>

namespace smaservo::page {

void Mailbox::wake_first(bool was_empty) const {
  if (was_empty) {
    wake_();
  }
}

void Mailbox::post(Errand errand) {
  const std::scoped_lock lock(mutex_);
  if (wake_ == nullptr) {
    return;
  }
  const bool was_empty = mail_.errands.empty() && mail_.live.empty();
  mail_.errands.push_back(std::move(errand));
  wake_first(was_empty);
}

void Mailbox::post(Live live) {
  const std::scoped_lock lock(mutex_);
  if (wake_ == nullptr) {
    return;
  }
  if (mail_.live.size() == room) {
    ++mail_.lost;
    return;
  }
  const bool was_empty = mail_.errands.empty() && mail_.live.empty();
  mail_.live.push_back(std::move(live));
  wake_first(was_empty);
}

Mailbox::Mail Mailbox::take() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(mail_, {});
}

void Mailbox::close() {
  const std::scoped_lock lock(mutex_);
  wake_ = nullptr;
  mail_ = {};
}

}  // namespace smaservo::page
