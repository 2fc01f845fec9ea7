#pragma once
// A guided run with one servo (host-sim/commission/live), whose person is a client, and the fit of
// the wire to it. One at a time; the last one is kept.

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/parameters/parameters.hpp"
#include "host-sim/commission/live/live.hpp"
#include "host-sim/page/servos/messages/requests.hpp"
#include "host-sim/page/source.hpp"
#include "host-sim/temporary_folder.hpp"

namespace smaservo::page {

/// Functions without another word may be called from any thread. Those that throw, throw UserError.
class Commissioner final : private commission::Person {
 public:
  /// Begins a run, which waits for its heat. Throws if there is one that has not ended.
  void begin(std::uint32_t client, const CommissionTask& task);
  /// The node whose run waits for its heat or is heated: the bus is not free for others.
  std::optional<unsigned> node_on_bus() const;

  /// What heat() leaves for fit().
  struct Heated {
    Settings<double> settings;  ///< of the servo
    std::unique_ptr<TemporaryFolder> folder;
    commission::LiveRun run;
  };
  /// Records the run that has begun; in the bus's thread. `looks` is called first, and then four
  /// times a second at least while it heats or asks, between two transfers: it throws if the run
  /// must end. Throws what record_live() throws, and Interrupted.
  Heated heat(can::Remote remote, const std::function<void()>& looks);
  /// Fits the wire of the servo's settings; takes some seconds. `goes_on` is asked from time to
  /// time. Throws what commission() throws; the files of the run stay.
  void fit(const Heated& heated, const std::function<bool()>& goes_on);
  /// Ends the run, which was not or cannot be finished.
  void failed(std::string_view why);

  /// Gives the answer of this client to the question that is asked. `reply` comes when the answer
  /// has been taken or refused. Throws if this client is asked nothing.
  void answer(std::uint32_t client, const nlohmann::json& request,
              std::function<void(Answer)> reply);
  /// Ends the run of this client. Returns the node that must be switched off, if any. Throws if
  /// this client leads none.
  std::optional<unsigned> cancel(std::uint32_t client);
  /// Notes that the run of this node is being ended, before its servo is switched off.
  void ends(unsigned node);
  bool is_cancelled() const;
  /// A file of the last run: the answer to `commission_file`. Throws if there is none.
  nlohmann::json file(const nlohmann::json& request) const;

  /// Whether anything has changed since this was called last.
  bool has_changed();
  /// Whether a run has begun and not ended.
  bool is_busy() const;
  /// The text of smaservo.Commission at this time of the bus.
  std::string message(std::int64_t now_us) const;

 private:
  enum class Stage : std::uint8_t {
    none,
    waiting,
    checking,
    asking,
    heating,
    fitting,
    done,
    failed
  };
  struct Pending {
    std::string typed;
    std::function<void(Answer)> reply;
    bool handed = false;
  };
  struct Files {
    std::string run, run_name, readings, readings_name, wire;
  };

  static const char* name_of(Stage stage);
  bool is_busy_now() const;
  void change_to(Stage stage);
  void end_question(std::unique_lock<std::mutex>& lock);
  nlohmann::json result_of(const Heated& heated, const std::function<bool()>& goes_on);

  // The members of Person, called by record_live() in the bus's thread.
  bool is_there() override { return true; }
  void show(std::string_view line) override;
  void say(std::string_view line) override;
  void ask(std::string_view question, std::int64_t until_us) override;
  std::optional<std::string> typed() override;
  void answered(std::string_view objection) override;

  std::function<void()> looks_;  ///< used only by the bus's thread

  mutable std::mutex mutex_;
  Stage stage_ = Stage::none;
  std::uint32_t client_ = 0;
  CommissionTask task_{};
  bool cancelled_ = false, changed_ = false;
  std::string line_, error_;
  std::deque<std::string> said_;
  std::int64_t until_us_ = 0;  ///< of the question
  std::optional<Pending> pending_;
  double share_ = 0;  ///< of the fit
  nlohmann::json result_;
  Files files_;
};

}  // namespace smaservo::page
