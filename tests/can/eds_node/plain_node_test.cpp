#include "tests/can/eds_node/plain_node.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/files/error.hpp"

namespace smaservo::test {
namespace {

using canopen::Type;
using testing::HasSubstr;

constexpr std::string_view sheet = R"([DeviceInfo]
VendorName=Somebody
VendorNumber=0x123
ProductNumber=7
[1000]
ParameterName=Device type
ObjectType=0x7
DataType=0x0007
AccessType=ro
DefaultValue=0x00030191
PDOMapping=0
[1001]
ParameterName=Error register
DataType=5
AccessType=ro
[1017]
ParameterName=Producer heartbeat time
DataType=0x0006
AccessType=rw
DefaultValue=0x64
[1018]
ParameterName=Identity
ObjectType=0x9
SubNumber=2
[1018sub0]
ParameterName=Highest
DataType=0x5
AccessType=ro
DefaultValue=1
[1018sub1]
ParameterName=Vendor
DataType=0x7
AccessType=ro
DefaultValue=0x123
[2000]
ParameterName=Small
DataType=0x3
AccessType=rw
LowLimit=-10
HighLimit=010
DefaultValue=-3
PDOMapping=1
[2001]
ParameterName=Text
DataType=0x9
AccessType=rw
DefaultValue=hello
[2002]
ParameterName=By node
DataType=0x7
AccessType=rw
DefaultValue=$NODEID+0x200
[2003]
ParameterName=Real
DataType=0x8
AccessType=rw
DefaultValue=1.5
[2004]
ParameterName=File
ObjectType=0x2
DataType=0xF
AccessType=rw
)";

class Client {
 public:
  explicit Client(std::string_view text, std::uint8_t id = 3)
      : node(parse_eds(text, "sheet", id), std::string(text), id), id_(id) {
    step();
  }
  std::vector<hal::CanFrame> step() {
    now_us += 1000;
    node.advance(now_us);
    return all();
  }
  std::vector<hal::CanFrame> all() {
    std::vector<hal::CanFrame> frames;
    for (hal::CanFrame f; node.take(f);) {
      frames.push_back(f);
    }
    return frames;
  }
  std::vector<std::uint8_t> ask(std::array<std::uint8_t, 8> request) {
    hal::CanFrame f;
    f.id = 0x600U + id_;
    f.length = 8;
    f.data = request;
    node.receive(f, now_us);
    const auto frames = all();
    return frames.empty() ? std::vector<std::uint8_t>{}
                          : std::vector<std::uint8_t>(frames[0].data.begin(), frames[0].data.end());
  }

  PlainNode node;
  std::uint64_t now_us = 0;

 private:
  std::uint8_t id_;
};

using Raw = std::vector<std::uint8_t>;

TEST(PlainNode, ServesWhatTheSheetSaysAndKeepsWhatIsWritten) {
  Client client(sheet);
  EXPECT_EQ(client.ask({0x40, 0x00, 0x10, 0}), (Raw{0x43, 0x00, 0x10, 0, 0x91, 0x01, 0x03, 0}));
  EXPECT_EQ(client.ask({0x40, 0x02, 0x20, 0}), (Raw{0x43, 0x02, 0x20, 0, 0x03, 0x02, 0, 0}));
  EXPECT_EQ(client.ask({0x40, 0x00, 0x20, 0}), (Raw{0x4B, 0x00, 0x20, 0, 0xFD, 0xFF, 0, 0}));
  EXPECT_EQ(client.ask({0x40, 0x03, 0x20, 0}), (Raw{0x43, 0x03, 0x20, 0, 0, 0, 0xC0, 0x3F}));
  EXPECT_EQ(client.ask({0x2B, 0x00, 0x20, 0, 8}), (Raw{0x60, 0x00, 0x20, 0, 0, 0, 0, 0}));
  EXPECT_EQ(client.ask({0x2B, 0x00, 0x20, 0, 9}), (Raw{0x80, 0x00, 0x20, 0, 0x31, 0, 9, 6}));
  EXPECT_EQ(client.ask({0x2B, 0x00, 0x20, 0, 0xF5, 0xFF}),
            (Raw{0x80, 0x00, 0x20, 0, 0x32, 0, 9, 6}));
  EXPECT_EQ(client.ask({0x40, 0x00, 0x20, 0}), (Raw{0x4B, 0x00, 0x20, 0, 8, 0, 0, 0}));
  EXPECT_EQ(client.ask({0x40, 0x00, 0x14, 1})[0], 0x80) << "it has no PDO";
  EXPECT_EQ(client.ask({0x40, 0x00, 0x20, 1}), (Raw{0x80, 0x00, 0x20, 1, 0x11, 0, 9, 6}));
}

TEST(PlainNode, BehavesAsTheSheetSays) {
  Client client(sheet);
  int beats = 0;
  for (int i = 0; i < 1000; ++i) {
    for (const hal::CanFrame& f : client.step()) {
      beats += f.id == 0x703 ? 1 : 0;
    }
  }
  EXPECT_EQ(beats, 10) << "100 ms";
}

TEST(EdsFile, TellsWhatIsWrongAndWhere) {
  const auto message = [](std::string_view text) -> std::string {
    try {
      parse_eds(text, "x.eds", 1);
    } catch (const files::UserError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message(""), HasSubstr("x.eds: has no objects"));
  EXPECT_THAT(message("[1000\n"), HasSubstr("x.eds:1: "));
  EXPECT_THAT(message("\nDataType=7\n"), HasSubstr("x.eds:2: "));
  EXPECT_THAT(message("[1000]\nDataType=7\n[1000]\n"), HasSubstr("x.eds:3: [1000]"));
  EXPECT_THAT(message("[1000]\nDataType=0x99\n"), HasSubstr("[1000] DataType=0x99"));
  EXPECT_THAT(message("[1000]\nDataType=7\nDefaultValue=x\n"), HasSubstr("DefaultValue=x"));
  EXPECT_THAT(message("[1000]\nDataType=7\nAccessType=x\n"), HasSubstr("AccessType=x"));
  EXPECT_EQ(message("\x1b[2J" + std::string(100, 'x')),
            "x.eds:1: ?[2J" + std::string(56, 'x') + "...: must be key=value within a section");
  EXPECT_THAT(message("[1000]\nDataType=7\n[1000sub0]\nDataType=7\n"), HasSubstr("1000h:0"));
}

}  // namespace
}  // namespace smaservo::test
