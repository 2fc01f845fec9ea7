#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace smaservo::hal {

/// The content of a file that may be compressed, by gzip, zstd or xz, as its first bytes tell;
/// several such files one behind the other are one. All functions that read throw files::UserError
/// where the data are damaged or end in the middle, or where the first bytes are those of a format
/// that is no table as text. Constant memory: at most 128 MiB for zstd, by its own limit, and for
/// xz.
class Unpacked {
 public:
  using Read = std::function<std::size_t(char* to, std::size_t room)>;

  /// `read` gives the bytes of the file; 0 at the end.
  explicit Unpacked(Read read);
  ~Unpacked();
  Unpacked(const Unpacked&) = delete;
  Unpacked& operator=(const Unpacked&) = delete;

  /// Returns the number of bytes; 0 at the end.
  std::size_t read(char* to, std::size_t room);
  /// The first bytes of the content, at least 8 if there are as many; before the first read().
  std::string_view head() const { return head_; }

  /// Whether the file is compressed.
  bool is_packed() const { return unpacker_ != nullptr; }

  /// Unpacks from `in`, of which it takes what it has unpacked.
  struct Unpacker {
    virtual std::size_t unpack(std::string_view& in, char* to, std::size_t room) = 0;
    /// Whether the data may end here.
    virtual bool is_whole() const = 0;
    virtual ~Unpacker() = default;
  };

 private:
  bool fill();
  std::size_t read_on(char* to, std::size_t room);

  Read read_;
  std::string block_;                   ///< bytes of the file
  std::string_view in_;                 ///< of block_: not taken yet
  bool ended_ = false;                  ///< the file
  std::unique_ptr<Unpacker> unpacker_;  ///< null: the file is not compressed
  std::string head_;                    ///< content that was read to look at it, and not given yet
};

}  // namespace smaservo::hal
