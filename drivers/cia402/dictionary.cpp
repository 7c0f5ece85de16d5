// The object dictionary of a simulated CiA 402 drive; see dictionary.hpp. Sources: README.md.
#include "drivers/cia402/dictionary.hpp"

namespace geodesic::drivers::cia402 {

namespace {

constexpr std::uint16_t kPdos = 4;
constexpr std::uint8_t kMostMapped = 4;
constexpr std::uint16_t kReceiveMaps = 0x1600;
constexpr std::uint16_t kTransmitMaps = 0x1A00;
constexpr std::uint16_t kMapToParameters = 0x200;

bool holds_a_map(std::uint16_t index) {
  return (index >= kReceiveMaps && index < kReceiveMaps + kPdos) ||
         (index >= kTransmitMaps && index < kTransmitMaps + kPdos);
}

bool holds_an_id(Object object) {
  return object.sub == 1 && ((object.index >= 0x1400 && object.index < 0x1400 + kPdos) ||
                             (object.index >= 0x1800 && object.index < 0x1800 + kPdos));
}

bool mappable(std::uint16_t index, bool receive) {
  switch (index) {
    case 0x6040:
    case 0x6060:
    case 0x6071:
      return receive;
    case 0x6041:
    case 0x6061:
    case 0x6064:
    case 0x606C:
    case 0x6077:
    case 0x603F:
      return !receive;
    default:
      return false;
  }
}

}  // namespace

Dictionary::Dictionary() {
  for (std::uint16_t pdo = 0; pdo < kPdos; ++pdo) {
    const auto at = [pdo](unsigned index, std::uint8_t sub, std::uint8_t bytes) {
      return Object{static_cast<std::uint16_t>(index + pdo), sub, bytes};
    };
    for (const unsigned parameters : {0x1400U, 0x1800U}) {
      add(at(parameters, 0, 1), Access::kConstant, 5);
      add(at(parameters, 1, 4), Access::kReadWrite, cob::kInvalid);
      add(at(parameters, 2, 1), Access::kReadWrite, kTypeAtOnce);
      add(at(parameters, 3, 2), Access::kReadWrite, 0);
      add(at(parameters, 5, 2), Access::kReadWrite, 0);
    }
    for (const unsigned map : {0x1600U, 0x1A00U}) {
      for (std::uint8_t sub = 0; sub <= kMostMapped; ++sub) {
        add(at(map, sub, sub == 0 ? 1 : 4), Access::kReadWrite, 0);
      }
    }
  }
}

void Dictionary::add(Object object, Access access, std::uint32_t value, bool stored) {
  if (count_ < kMost) {
    entries_[count_++] = {object, access, stored, value, value};
  }
}

void Dictionary::remove(Object object) {
  for (std::size_t i = 0; i < count_; ++i) {
    if (entries_[i].object.index == object.index && entries_[i].object.sub == object.sub) {
      entries_[i] = entries_[--count_];
      return;
    }
  }
}

const Dictionary::Entry* Dictionary::find(std::uint16_t index, std::uint8_t sub) const {
  for (std::size_t i = 0; i < count_; ++i) {
    if (entries_[i].object.index == index && entries_[i].object.sub == sub) {
      return &entries_[i];
    }
  }
  return nullptr;
}

Dictionary::Entry* Dictionary::find(std::uint16_t index, std::uint8_t sub) {
  return const_cast<Entry*>(static_cast<const Dictionary*>(this)->find(index, sub));
}

std::uint32_t Dictionary::value(Object object) const {
  const Entry* entry = find(object.index, object.sub);
  return entry == nullptr ? 0 : entry->value;
}

std::int32_t Dictionary::signed_value(Object object) const {
  const std::uint32_t raw = value(object);
  switch (object.bytes) {
    case 1:
      return static_cast<std::int8_t>(raw);
    case 2:
      return static_cast<std::int16_t>(raw);
    default:
      return static_cast<std::int32_t>(raw);
  }
}

void Dictionary::set(Object object, std::uint32_t value) {
  if (Entry* entry = find(object.index, object.sub)) {
    const unsigned unused = 32U - 8U * entry->object.bytes;
    entry->value = value << unused >> unused;
  }
}

void Dictionary::set_factory(Object object, std::uint32_t value) {
  set(object, value);
  if (Entry* entry = find(object.index, object.sub)) {
    entry->power_on = entry->value;
  }
}

std::optional<Abort> Dictionary::missing(std::uint16_t index) const {
  for (std::size_t i = 0; i < count_; ++i) {
    if (entries_[i].object.index == index) {
      return Abort::kNoSub;
    }
  }
  return Abort::kNoObject;
}

std::optional<Abort> Dictionary::read(std::uint16_t index, std::uint8_t sub, Object& found) const {
  const Entry* entry = find(index, sub);
  if (entry == nullptr) {
    return missing(index);
  }
  found = entry->object;
  return std::nullopt;
}

std::optional<Abort> Dictionary::write(std::uint16_t index, std::uint8_t sub, std::uint8_t bytes,
                                       std::uint32_t value) {
  Entry* entry = find(index, sub);
  if (entry == nullptr) {
    return missing(index);
  }
  if (entry->access != Access::kReadWrite) {
    return Abort::kReadOnly;
  }
  if (bytes != 0 && bytes != entry->object.bytes) {
    return Abort::kLength;
  }
  if (holds_a_map(index)) {
    if (const std::optional<Abort> why = check_mapping(*entry, value)) {
      return why;
    }
  }
  if (holds_an_id(entry->object) && ((entry->value | value) & cob::kInvalid) == 0 &&
      entry->value != value) {
    return Abort::kRange;  // a PDO in use keeps its identifier
  }
  entry->value = value;
  return std::nullopt;
}

std::optional<Abort> Dictionary::check_mapping(const Entry& entry, std::uint32_t value) const {
  const std::uint16_t index = entry.object.index;
  const Object id{static_cast<std::uint16_t>(index - kMapToParameters), 1, 4};
  if ((this->value(id) & cob::kInvalid) == 0) {
    return Abort::kDeviceState;  // the PDO is in use
  }
  const bool receive = index < kTransmitMaps;
  if (entry.object.sub != 0) {
    const auto mapped = static_cast<std::uint16_t>(value >> 16U);
    const Entry* object = find(mapped, static_cast<std::uint8_t>(value >> 8U & 0xFFU));
    if (this->value({index, 0, 1}) != 0) {
      return Abort::kDeviceState;  // its count has not been cleared
    }
    if (object == nullptr) {
      return Abort::kNoObject;
    }
    const bool fits = (value & 0xFFU) == object->object.bytes * 8U;
    return fits && mappable(mapped, receive) ? std::nullopt : std::optional(Abort::kNotMappable);
  }
  if (value > kMostMapped) {
    return Abort::kPdoTooLong;
  }
  std::uint32_t bits = 0;
  for (std::uint32_t sub = 1; sub <= value; ++sub) {
    bits += this->value({index, static_cast<std::uint8_t>(sub), 4}) & 0xFFU;
  }
  return bits > 64 ? std::optional(Abort::kPdoTooLong) : std::nullopt;
}

void Dictionary::power_on() {
  for (std::size_t i = 0; i < count_; ++i) {
    entries_[i].value = entries_[i].power_on;
  }
}

void Dictionary::reset_communication() {
  for (std::size_t i = 0; i < count_; ++i) {
    if (entries_[i].object.index < 0x2000) {
      entries_[i].value = entries_[i].power_on;
    }
  }
}

void Dictionary::store() {
  for (std::size_t i = 0; i < count_; ++i) {
    if (entries_[i].stored) {
      entries_[i].power_on = entries_[i].value;
    }
  }
}

}  // namespace geodesic::drivers::cia402
