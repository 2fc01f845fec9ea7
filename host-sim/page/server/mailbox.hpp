#pragma once
// Passes messages from all threads to the server's thread. The only waiting is for this mutex,
// which is held for as long as it takes to append a pointer.

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

  /// Greatest number of live messages: some seconds at 1 kHz during which the server did not run.
  static constexpr std::size_t room = 4096;

  /// `wake` is called when mail comes into an empty box.
  explicit Mailbox(std::function<void()> wake) : wake_(std::move(wake)) {}

  void post(Errand errand);
  void post(Live live);
  Mail take();
  /// Calls `wake` no more, and drops new mail.
  void close();

 private:
  void wake_first(bool was_empty) const;

  std::mutex mutex_;
  std::function<void()> wake_;
  Mail mail_;
};

}  // namespace smaservo::page
