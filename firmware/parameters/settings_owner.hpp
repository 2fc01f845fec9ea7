#pragma once
// Who owns the settings in force. Staging changes them through this interface and keeps none
// itself, so that there is one place that says what is in force, and one count of the changes.

#include <cstdint>

#include "firmware/settings.hpp"

namespace smaservo {

template <class S>
class SettingsOwner {
 public:
  /// The settings that were put last, and that a reader takes for those in force. For the thread
  /// that changes them.
  virtual const Settings<S>& settings() const = 0;
  /// Whether a change can be taken now. Where it cannot, a person's changes are refused; what ends
  /// by itself, as a trial does, is put all the same.
  virtual bool has_room() const = 0;
  /// The settings must have passed check().
  virtual void put(const Settings<S>& settings) = 0;

 protected:
  ~SettingsOwner() = default;
};

/// The owner in a program with a single thread, which compares changes() with the number that it
/// has adopted.
template <class S>
class OwnSettings final : public SettingsOwner<S> {
 public:
  explicit OwnSettings(const Settings<S>& settings) : settings_(settings) {}

  const Settings<S>& settings() const override { return settings_; }
  bool has_room() const override { return true; }
  void put(const Settings<S>& settings) override {
    settings_ = settings;
    ++changes_;
  }
  /// Counts the calls of put().
  std::uint32_t changes() const { return changes_; }

 private:
  Settings<S> settings_;
  std::uint32_t changes_ = 0;
};

}  // namespace smaservo
