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

std::optional<std::uint32_t> ParameterDesk::change(const Settings<double>& settings,
                                                   std::optional<std::uint32_t> from) {
  const std::scoped_lock lock(mutex_);
  delete_old();
  if (must_go_back_ || (from && *from != last_.load())) {
    return std::nullopt;
  }
  std::string text = text::changes_text(settings_, settings);
  if (text.empty()) {
    return last_;
  }
  if (in_line_.size() > max_under_way) {
    return std::nullopt;
  }
  ParameterSetPtr set = make_parameter_set(settings, ++last_);
  texts_.emplace(last_, std::move(text));
  settings_ = settings;
  in_line_.push_back({last_, settings});
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
    if (is_refused(*owned)) {
      take_back(number_of(*owned));
    } else {
      in_line_.pop_front();
    }
  }
  if (must_go_back_ && in_line_.size() == 1) {
    must_go_back_ = false;
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
