#pragma once
// Keeps the settings over a power cut: two slots, of which the older one is overwritten.
// load_settings() reports which slot it took and why, and whether the settings stored last may be
// lost; it never silently takes defaults or older values.

#include <concepts>

#include "firmware/parameters/store/store_image.hpp"

namespace smaservo {

/// Two slots of memory. Each call may fail, or be cut off by a loss of power at any byte; the bytes
/// to be erased or written may then have any value. read() fails beyond the end of a slot.
template <class T>
concept Storage = requires(T storage, unsigned slot, std::size_t offset, std::span<std::byte> to,
                           std::span<const std::byte> from) {
  { storage.read(slot, offset, to) } -> std::same_as<bool>;
  { storage.erase(slot) } -> std::same_as<bool>;
  { storage.write(slot, offset, from) } -> std::same_as<bool>;
  { storage.sync() } -> std::same_as<bool>;  ///< returns when all that was written is durable
};
inline constexpr unsigned slot_count = 2;

enum class SlotState : std::uint8_t {
  valid,
  empty,           ///< never written, or erased
  unreadable,      ///< the storage cannot be read
  damaged,         ///< not an image, or its checksum is wrong
  unknown_format,  ///< an image of a newer release
  refused,         ///< intact, but its settings are out of range or contradict each other
};

/// What is in a slot.
struct SlotReport {
  SlotState state = SlotState::unreadable;
  std::uint32_t sequence = 0;  ///< valid only if intact(), as are all members below
  std::uint32_t schema_hash = 0;
  std::uint16_t entries = 0;
  std::uint16_t unknown = 0;  ///< entries that this release does not know
  std::uint16_t moved = 0;    ///< parameters taken from an old key
  std::uint16_t missing = 0;  ///< parameters that got their default
  Finding finding;            ///< the reason if it is refused

  /// Whether the image that was written is complete, even if this release cannot use it.
  constexpr bool intact() const {
    return state == SlotState::valid || state == SlotState::unknown_format ||
           state == SlotState::refused;
  }
};

/// Whether the sequence number `a` was given after `b`. The number wraps from FFFFFFFFh to 0 (like
/// the serial numbers of RFC 1982): the later one is ahead by less than half of all numbers.
constexpr bool is_later(std::uint32_t a, std::uint32_t b) {
  constexpr std::uint32_t half = 0x8000'0000;
  return a != b && a - b < half;
}

enum class LoadReason : std::uint8_t {
  newer,      ///< the newer of two valid slots
  only_one,   ///< the other slot is empty
  other_bad,  ///< the other slot is not valid: its report says why
  none,       ///< no slot is valid
};

/// The result of load_settings().
template <class S>
struct Loaded {
  LoadReason reason = LoadReason::none;
  unsigned slot = 0;
  std::array<SlotReport, slot_count> slots;
  Settings<S> settings;  ///< all zero if the reason is `none`
  /// The other slot is bad or missing, and may have held settings that were stored later.
  bool may_be_older = false;
};

enum class SaveProblem : std::uint8_t {
  none,
  refused,    ///< settings out of range or contradictory: see the finding; nothing was written
  erase,      ///< the storage failed to erase
  write,      ///< the storage failed to write
  sync,       ///< the storage failed to make the data durable
  read_back,  ///< the storage failed while the data were being read back
  differs,    ///< the data read back differ from those written
};

/// The result of save_settings().
struct Saved {
  SaveProblem problem = SaveProblem::none;
  unsigned slot = 0;
  std::uint32_t sequence = 0;
  Finding finding{};

  /// Whether the settings are stored.
  constexpr bool ok() const { return problem == SaveProblem::none; }
};

namespace detail {

constexpr bool is_erased(std::span<const std::byte> bytes) {
  return std::ranges::all_of(bytes, [&](std::byte b) { return b == bytes[0]; }) &&
         (bytes[0] == std::byte{0xFF} || bytes[0] == std::byte{0});
}

template <class S, Storage T>
SlotReport read_slot(T& storage, unsigned slot, const StoreSchema<S>& schema,
                     Settings<S>& settings) {
  SlotReport report;
  std::array<std::byte, image::header_size> bytes{};
  if (!storage.read(slot, 0, bytes)) {
    return report;
  }
  const image::Header header = image::take_header(bytes);
  report.state = is_erased(bytes) ? SlotState::empty : SlotState::damaged;
  if (header.magic != image::magic || header.entries > image::max_entries) {
    return report;
  }
  Crc32 crc;
  crc.add(bytes);
  image::Reader<S> reader(schema);
  std::size_t at = image::header_size;
  std::array<std::byte, image::entry_size> entry{};
  for (int i = 0; i < header.entries; ++i, at += entry.size()) {
    if (!storage.read(slot, at, entry)) {
      return report;
    }
    crc.add(entry);
    reader.add(entry);
  }
  std::array<std::byte, image::crc_size> sum{};
  if (!storage.read(slot, at, sum) || image::take<std::uint32_t>(sum) != crc.value()) {
    return report;
  }
  report = {SlotState::valid, header.sequence, header.schema_hash, header.entries,
            reader.unknown(), reader.moved(),  reader.missing(),   reader.finding()};
  if (header.format != image::format) {
    report.state = SlotState::unknown_format;
  } else if (!report.finding.ok()) {
    report.state = SlotState::refused;
  } else {
    settings = reader.settings();
  }
  return report;
}

/// Whether settings stored later than those of the valid slot may have been lost with the other
/// slot. A damaged slot does not tell its sequence number. Each save leaves two filled slots, so an
/// empty one was lost; if the valid slot has number 1, the lost number 2 had the same settings.
constexpr bool may_have_lost_newer(const SlotReport& valid, const SlotReport& other) {
  switch (other.state) {
    case SlotState::valid:
      return false;
    case SlotState::empty:
      return valid.sequence != 1;
    case SlotState::unknown_format:
    case SlotState::refused:
      return is_later(other.sequence, valid.sequence);
    case SlotState::unreadable:
    case SlotState::damaged:
      break;
  }
  return true;
}

}  // namespace detail

/// Calls f(row, value) for each parameter of which a slot still has an entry with a possible value.
/// Neither the checksum nor the header is checked: the values are only for a message on the
/// possible content of a bad slot.
template <class S, Storage T, class F>
void salvage(T& storage, unsigned slot, F f, const StoreSchema<S>& schema = own_schema<S>) {
  std::array<std::byte, image::entry_size> bytes{};
  for (std::size_t i = 0; i < schema.rows.size() + schema.moved.size(); ++i) {
    if (!storage.read(slot, image::header_size + i * bytes.size(), bytes)) {
      return;
    }
    const image::Entry entry = image::take_entry(bytes);
    const ParameterRow<S>* const row = find_row(schema.rows, entry.key);
    if (row != nullptr && row->type == entry.type && fit(*row, entry.value) == Fit::inside) {
      f(*row, entry.value);
    }
  }
}

/// Reads both slots. Never fails; problems are in the reports.
template <class S, Storage T>
Loaded<S> load_settings(T& storage, const StoreSchema<S>& schema = own_schema<S>) {
  Loaded<S> loaded{};
  std::array<Settings<S>, slot_count> settings{};
  for (unsigned slot = 0; slot < slot_count; ++slot) {
    loaded.slots[slot] = detail::read_slot(storage, slot, schema, settings[slot]);
  }
  const auto& [a, b] = loaded.slots;
  const bool a_valid = a.state == SlotState::valid;
  const bool b_valid = b.state == SlotState::valid;
  if (!a_valid && !b_valid) {
    return loaded;
  }
  loaded.slot = b_valid && (!a_valid || is_later(b.sequence, a.sequence)) ? 1 : 0;
  loaded.settings = settings[loaded.slot];
  loaded.reason = a_valid && b_valid                                        ? LoadReason::newer
                  : loaded.slots[1 - loaded.slot].state == SlotState::empty ? LoadReason::only_one
                                                                            : LoadReason::other_bad;
  loaded.may_be_older =
      detail::may_have_lost_newer(loaded.slots[loaded.slot], loaded.slots[1 - loaded.slot]);
  return loaded;
}

namespace detail {

/// The number of a save that keeps the slot `kept` and overwrites `replaced`: it must be later than
/// that of `kept`. The number of `replaced` counts only if `kept` is not intact.
constexpr std::uint32_t next_sequence(const SlotReport& kept, const SlotReport& replaced) {
  return kept.intact() ? kept.sequence + 1 : replaced.intact() ? replaced.sequence + 1 : 1;
}

/// Erases a slot, writes an image into it, reads it back and compares.
template <class S, Storage T>
SaveProblem write_slot(T& storage, unsigned slot, const Settings<S>& settings,
                       std::uint32_t sequence, const StoreSchema<S>& schema) {
  if (!storage.erase(slot)) {
    return SaveProblem::erase;
  }
  std::size_t at = 0;
  const bool written =
      image::write(schema, settings, sequence, [&](std::span<const std::byte> chunk) {
        const bool ok = storage.write(slot, at, chunk);
        at += chunk.size();
        return ok;
      });
  if (!written) {
    return SaveProblem::write;
  }
  if (!storage.sync()) {
    return SaveProblem::sync;
  }
  at = 0;
  bool readable = true;
  const bool same = image::write(schema, settings, sequence, [&](std::span<const std::byte> chunk) {
    std::array<std::byte, image::chunk_size> back{};
    const auto kept = std::span(back).first(chunk.size());
    readable = storage.read(slot, at, kept);
    at += chunk.size();
    return readable && std::ranges::equal(kept, chunk);
  });
  return same ? SaveProblem::none : readable ? SaveProblem::differs : SaveProblem::read_back;
}

}  // namespace detail

/// Writes into the slot that load_settings() would not take, reads it back and compares. Whatever
/// fails, and whenever power is cut, load_settings() gives either the former settings or the new
/// ones. Not for the loop.
///
/// The first save writes both slots, as numbers 1 and 2. So a slot found empty later was lost, and
/// the remaining one may be older, except if it is number 1, whose copy is number 2. If number 1
/// would remain next to other settings, it is overwritten, too.
template <class S, Storage T>
Saved save_settings(T& storage, const Settings<S>& settings,
                    const StoreSchema<S>& schema = own_schema<S>) {
  Saved saved{};
  saved.finding = check(settings);
  if (!saved.finding.ok()) {
    saved.problem = SaveProblem::refused;
    return saved;
  }
  const Loaded<S> before = load_settings(storage, schema);
  saved.slot = before.reason == LoadReason::none ? 0 : 1 - before.slot;
  const SlotReport& kept = before.slots[1 - saved.slot];
  const bool copies = before.reason == LoadReason::none || kept.sequence < 2;
  saved.sequence = detail::next_sequence(kept, before.slots[saved.slot]);
  saved.problem = detail::write_slot(storage, saved.slot, settings, saved.sequence, schema);
  if (saved.ok() && copies) {
    saved.slot = 1 - saved.slot;
    ++saved.sequence;
    saved.problem = detail::write_slot(storage, saved.slot, settings, saved.sequence, schema);
  }
  return saved;
}

}  // namespace smaservo
