// Error frames in words; see the header. Source: linux/can/error.h.
#include "tools/geodesic/error_frame_words.hpp"

#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/error.h>

#include <array>
#include <string>

namespace geodesic::tools {
namespace {

struct Bit {
  unsigned mask;
  const char* words;
};

constexpr std::array kController = {
    Bit{CAN_ERR_CRTL_RX_OVERFLOW, "receive buffer overflowed"},
    Bit{CAN_ERR_CRTL_TX_OVERFLOW, "transmit buffer overflowed"},
    Bit{CAN_ERR_CRTL_RX_WARNING, "many errors receiving (warning)"},
    Bit{CAN_ERR_CRTL_TX_WARNING, "many errors sending (warning)"},
    Bit{CAN_ERR_CRTL_RX_PASSIVE, "error-passive by receiving"},
    Bit{CAN_ERR_CRTL_TX_PASSIVE, "error-passive by sending"},
    Bit{CAN_ERR_CRTL_ACTIVE, "error-active again"},
};

constexpr std::array kProtocol = {
    Bit{CAN_ERR_PROT_BIT, "a bit was not what was sent"},
    Bit{CAN_ERR_PROT_FORM, "a fixed bit is wrong (bit rate?)"},
    Bit{CAN_ERR_PROT_STUFF, "bit stuffing is wrong (bit rate?)"},
    Bit{CAN_ERR_PROT_BIT0, "could not send a dominant bit (wiring?)"},
    Bit{CAN_ERR_PROT_BIT1, "could not send a recessive bit (short circuit?)"},
    Bit{CAN_ERR_PROT_OVERLOAD, "overload"},
    Bit{CAN_ERR_PROT_ACTIVE, "an active error was announced"},
    Bit{CAN_ERR_PROT_TX, "while sending"},
};

template <std::size_t kCount>
std::string words_of(unsigned byte, const std::array<Bit, kCount>& bits) {
  std::string text;
  for (const Bit& bit : bits) {
    if ((byte & bit.mask) == 0) continue;
    text += text.empty() ? "" : ", ";
    text += bit.words;
  }
  return text.empty() ? std::string("unspecified") : text;
}

}  // namespace

std::vector<drivers::DecodedField> error_frame_words(const drivers::Frame& frame) {
  std::vector<drivers::DecodedField> fields;
  const auto say = [&](unsigned mask, const char* name, std::string words) {
    if ((frame.id & mask) != 0) fields.push_back({name, std::move(words), ""});
  };
  say(CAN_ERR_TX_TIMEOUT, "sending", "timed out");
  say(CAN_ERR_LOSTARB, "arbitration", fmt::format("lost in bit {}", frame.data[0]));
  say(CAN_ERR_CRTL, "controller", words_of(frame.data[1], kController));
  say(CAN_ERR_PROT, "protocol", words_of(frame.data[2], kProtocol));
  say(CAN_ERR_TRX, "transceiver", fmt::format("status 0x{:02X} (wiring)", frame.data[4]));
  say(CAN_ERR_ACK, "acknowledgement", "none: nobody else on the bus takes frames");
  say(CAN_ERR_BUSOFF, "bus-off", "the controller has left the bus");
  say(CAN_ERR_BUSERROR, "bus error", "yes");
  say(CAN_ERR_RESTARTED, "restarted", "the controller is back on the bus");
  constexpr unsigned kCounters = 0x200;  // CAN_ERR_CNT, newer than some headers
  if ((frame.id & kCounters) != 0) {
    fields.push_back({"errors sending", fmt::format("{}", frame.data[6]), ""});
    fields.push_back({"errors receiving", fmt::format("{}", frame.data[7]), ""});
  }
  if (fields.empty()) fields.push_back({"class", fmt::format("0x{:X}", frame.id), ""});
  return fields;
}

}  // namespace geodesic::tools
