#pragma once
// From all threads to the server's one. Nobody waits for anything but this mutex, which is held for
// as long as it takes to append a pointer.

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace smaservo::page {

class Mailbox {
 public:
  using Errand = std::function<void()>;

  struct Live {
    std::uint32_t channel;
    std::int64_t time_ns;
    std::shared_ptr<const std::string> bytes;
  };

  struct Mail {
    std::vector<Errand> errands;
    std::vector<Live> live;
    std::uint64_t lost = 0;  ///< live messages for which there was no room
  };

  /// Room for live messages: some seconds at 1 kHz, in which the server did not run at all.
  static constexpr std::size_t room = 4096;

  /// `wake` is called when the first mail comes into an empty box.
  explicit Mailbox(std::function<void()> wake) : wake_(std::move(wake)) {}

  void post(Errand errand);
  void post(Live live);
  Mail take();
  /// Wakes nobody any more, and forgets what comes.
  void close();

 private:
  void wake_first(bool was_empty) const;

  std::mutex mutex_;
  std::function<void()> wake_;
  Mail mail_;
};

}  // namespace smaservo::page
