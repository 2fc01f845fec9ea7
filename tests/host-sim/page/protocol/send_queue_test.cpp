#include "host-sim/page/protocol/send_queue.hpp"

#include <gmock/gmock.h>
#include <random>

namespace smaservo::page {
namespace {

Frame frame(bool live, std::uint64_t number, std::size_t bytes = 8) {
  return {.live = live,
          .head = std::to_string(number),
          .body = std::make_shared<std::string>(bytes, ' ')};
}

TEST(SendQueue, GivesAnswersFirst) {
  SendQueue queue;
  queue.push(frame(true, 1));
  queue.push(frame(false, 2));
  queue.push(frame(true, 3));
  queue.push(frame(false, 4));
  for (const char* next : {"2", "4", "1", "3"}) {
    EXPECT_EQ(queue.pop()->head, next);
  }
  EXPECT_FALSE(queue.pop());
}

// Against what must hold whatever happens: order, and every message is sent, waiting, or counted.
TEST(SendQueue, LosesTheOldestLiveMessagesOnlyAndCountsThem) {
  std::mt19937 random(20);
  const SendQueue::Bounds bounds{
      .live_messages = 16, .live_bytes = 800, .answers = 100000, .answer_bytes = 100000000};
  for (int round = 0; round < 50; ++round) {
    SendQueue queue(bounds);
    std::uint64_t pushed = 0, popped = 0, live_waiting = 0, last_live = 0, last_answer = 0;
    const std::uint32_t pops = 1 + random() % 4;
    for (int i = 0; i < 2000; ++i) {
      if (random() % 5 >= pops) {
        const bool live = random() % 4 != 0;
        ++pushed;
        live_waiting += live ? 1U : 0U;
        const std::uint64_t before = queue.dropped();
        EXPECT_TRUE(queue.push(frame(live, pushed, random() % 120)));
        EXPECT_TRUE(live || queue.dropped() == before);
        live_waiting -= queue.dropped() - before;
        EXPECT_LE(live_waiting, bounds.live_messages);
        EXPECT_TRUE(!live || live_waiting > 0) << "the newest stays";
      } else if (const auto next = queue.pop()) {
        ++popped;
        live_waiting -= next->live ? 1U : 0U;
        std::uint64_t& last = next->live ? last_live : last_answer;
        EXPECT_GT(std::stoull(next->head), last);
        last = std::stoull(next->head);
      }
      EXPECT_EQ(pushed, popped + queue.size() + queue.dropped());
    }
  }
}

TEST(SendQueue, BoundsTheBytesOfLiveMessages) {
  SendQueue queue({.live_messages = 1000, .live_bytes = 10000});
  for (std::uint64_t i = 0; i < 100; ++i) {
    queue.push(frame(true, i, 998));
  }
  EXPECT_EQ(queue.size(), 10U);
  EXPECT_EQ(queue.dropped(), 90U);
  queue.push(frame(true, 100, 50000));
  EXPECT_EQ(queue.size(), 1U) << "one that is longer than all stays alone";
  EXPECT_EQ(queue.pop()->head, "100");
  queue.push(frame(true, 101, 998));
  queue.push(frame(true, 102, 998));
  EXPECT_EQ(queue.size(), 2U) << "its bytes are not counted any more";
}

TEST(SendQueue, SaysWhenAnswersAreNotRead) {
  SendQueue by_number({.answers = 3});
  EXPECT_TRUE(by_number.push(frame(false, 1)));
  EXPECT_TRUE(by_number.push(frame(false, 2)));
  EXPECT_TRUE(by_number.push(frame(false, 3)));
  EXPECT_FALSE(by_number.push(frame(false, 4)));
  SendQueue by_bytes({.answer_bytes = 1000});
  EXPECT_TRUE(by_bytes.push(frame(false, 1, 999)));
  EXPECT_FALSE(by_bytes.push(frame(false, 2, 1)));
}

}  // namespace
}  // namespace smaservo::page
