#include "firmware/daemon/loop/desk.hpp"

#include <utility>

#include "firmware/text/settings_text.hpp"

namespace smaservo::daemon {

ParameterDesk::~ParameterDesk() {
  delete_old();
  ParameterSet* set = nullptr;
  while (links_.new_sets.pop(set)) {
    const ParameterSetPtr owned(set);
  }
}

void ParameterDesk::put(const Settings<double>& settings) {
  const std::scoped_lock lock(mutex_);
  settings_ = settings;
  waits_ = true;
}

std::uint32_t ParameterDesk::give() {
  const std::scoped_lock lock(mutex_);
  return give_locked();
}

std::uint32_t ParameterDesk::give_locked() {
  if (!waits_ || !has_room()) {
    return last_;
  }
  waits_ = false;
  std::string text = text::changes_text(in_line_.back().settings, settings_);
  if (text.empty()) {
    return last_;
  }
  ParameterSetPtr set = make_parameter_set(settings_, ++last_);
  texts_.emplace(last_, std::move(text));
  in_line_.push_back({last_, settings_});
  links_.new_sets.push(set.release());
  return last_;
}

bool ParameterDesk::change(const Settings<double>& settings, std::optional<std::uint32_t> from) {
  const std::scoped_lock lock(mutex_);
  delete_old();
  if (!has_room() || (from && *from != last_.load())) {
    return false;
  }
  settings_ = settings;
  waits_ = true;
  give_locked();
  return true;
}

void ParameterDesk::tidy() {
  const std::scoped_lock lock(mutex_);
  delete_old();
}

void ParameterDesk::delete_old() {
  ParameterSet* set = nullptr;
  while (links_.old_sets.pop(set)) {
    const ParameterSetPtr owned(set);
    if (is_refused(*owned)) {
      take_back(number_of(*owned));
    } else {
      in_line_.pop_front();
    }
  }
  if (must_go_back_ && in_line_.size() == 1) {
    must_go_back_ = waits_ = false;
    settings_ = in_line_.front().settings;
    ++last_;
  }
}

void ParameterDesk::take_back(std::uint32_t number) {
  must_go_back_ = true;
  std::erase_if(in_line_, [&](const Numbered& set) { return set.number == number; });
  refused_.push_back(texts_[number]);
  texts_.erase(number);
}

std::vector<std::string> ParameterDesk::take_refused() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(refused_, {});
}

Settings<double> ParameterDesk::copy() const {
  const std::scoped_lock lock(mutex_);
  return settings_;
}

std::string ParameterDesk::take_text(std::uint32_t number) {
  const std::scoped_lock lock(mutex_);
  const auto found = texts_.find(number);
  if (found == texts_.end()) {
    return {};
  }
  std::string text = std::move(found->second);
  texts_.erase(found);
  return text;
}

}  // namespace smaservo::daemon
