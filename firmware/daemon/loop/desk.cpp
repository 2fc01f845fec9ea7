#include "firmware/daemon/loop/desk.hpp"

#include "firmware/text/settings_text.hpp"

namespace smaservo::daemon {

ParameterDesk::~ParameterDesk() {
  delete_old();
  ParameterSet* set = nullptr;
  while (links_.new_sets.pop(set)) {
    const ParameterSetPtr owned(set);
  }
}

std::optional<std::uint32_t> ParameterDesk::change(const Settings<double>& settings) {
  const std::scoped_lock lock(mutex_);
  std::string text = text::changes_text(settings_, settings);
  if (text.empty()) {
    return last_;
  }
  delete_old();
  if (under_way_ == max_under_way) {
    return std::nullopt;
  }
  ParameterSetPtr set = make_parameter_set(settings, ++last_);
  texts_.emplace(last_, std::move(text));
  settings_ = settings;
  ++under_way_;
  links_.new_sets.push(set.release());
  return last_;
}

void ParameterDesk::tidy() {
  const std::scoped_lock lock(mutex_);
  delete_old();
}

void ParameterDesk::delete_old() {
  ParameterSet* set = nullptr;
  while (links_.old_sets.pop(set)) {
    const ParameterSetPtr owned(set);
    --under_way_;
  }
}

Settings<double> ParameterDesk::settings() const {
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
