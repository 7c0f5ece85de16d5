// Reads the bare exchange's command line.
#include "tests/bench/bare_options.hpp"

#include <getopt.h>
#include <linux/can.h>
#include <sched.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/bench/bare_bus.hpp"

namespace geodesic::bench {
namespace {

constexpr const char* kUsage =
    R"(usage: bare_exchange ROLE BUS[,BUS...] [options]
  ROLE  commander   sends N frames a cycle on each bus in one batch and waits for N replies
        responder   answers each; until SIGTERM
        pair        both, as two processes
  BUS   a CAN interface (can0, vcan0), or unix:PATH, a socket bus that somebody serves
  --count N        frames a cycle on each bus, 1..64            (7)
  --ids A,B,...    their identifiers; implies --count           (1, 2, ...)
  --reply-ids ...  identifiers of the replies                   (17, 18, ...)
  --extended       29-bit identifiers
  --length N       data bytes, 1..8, with --fd up to 64         (8)
  --fd             CAN FD frames with bit-rate switch
  --cycles N       measured cycles                              (10000)
  --warm-up N      cycles before them                           (200)
  --rate HZ        cycles a second                              (1000)
  --budget SHARE   of the period to wait for replies            (0.9)
  --priority N     SCHED_FIFO, if allowed; 0: as started        (80)
  --cpu N          run on this processor                        (any)
  --reply-gap US   responder: replies leave one by one, so far apart (0: one batch)
  --json           figures as JSON
)";

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t comma = 0; comma != std::string::npos; begin = comma + 1) {
    comma = list.find(',', begin);
    parts.push_back(list.substr(begin, comma - begin));
  }
  return parts;
}

double number(const char* option, const std::string& text, double low, double high) {
  char* end = nullptr;
  const bool hexadecimal = text.starts_with("0x");
  const double value = hexadecimal ? static_cast<double>(std::strtol(text.c_str(), &end, 16))
                                   : std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !(value >= low && value <= high)) {
    fail("--%s %s: a number from %g to %g is expected", option, text.c_str(), low, high);
  }
  return value;
}

std::vector<std::uint32_t> identifiers(const char* option, const std::string& list) {
  std::vector<std::uint32_t> ids;
  for (const std::string& part : split(list)) {
    ids.push_back(static_cast<std::uint32_t>(number(option, part, 0, CAN_EFF_MASK)));
  }
  return ids;
}

void set(BareOptions& options, std::size_t& count, const char* name, const std::string& text) {
  const auto is = [name](const char* other) { return std::strcmp(name, other) == 0; };
  const auto given = [&](double low, double high) { return number(name, text, low, high); };
  if (is("count")) {
    count = static_cast<std::size_t>(given(1, kMaxFrames));
  } else if (is("ids")) {
    options.ids = identifiers(name, text);
    count = options.ids.size();
  } else if (is("reply-ids")) {
    options.reply_ids = identifiers(name, text);
  } else if (is("extended")) {
    options.extended = true;
  } else if (is("length")) {
    options.length = static_cast<std::uint8_t>(given(1, 64));
  } else if (is("fd")) {
    options.fd = true;
  } else if (is("cycles")) {
    options.cycles = static_cast<std::int64_t>(given(1, 1e9));
  } else if (is("warm-up")) {
    options.warm_up = static_cast<std::int64_t>(given(0, 1e9));
  } else if (is("rate")) {
    options.period_ns = static_cast<std::int64_t>(1e9 / given(0.1, 1e5));
  } else if (is("budget")) {
    options.budget = given(0.01, 1.0);
  } else if (is("priority")) {
    options.priority = static_cast<int>(given(0, 99));
  } else if (is("cpu")) {
    options.cpu = static_cast<int>(given(0, CPU_SETSIZE - 1));
  } else if (is("reply-gap")) {
    options.reply_gap_ns = static_cast<std::int64_t>(1e3 * given(0, 1e6));
  } else if (is("json")) {
    options.json = true;
  }
}

void check(const BareOptions& options) {
  if (options.role != "commander" && options.role != "responder" && options.role != "pair") {
    fail("\"%s\" is no role; it is commander, responder or pair", options.role.c_str());
  }
  if (options.ids.size() > kMaxFrames || options.ids.size() != options.reply_ids.size()) {
    fail("%zu identifiers and %zu of replies; expected as many of each, at most %zu",
         options.ids.size(), options.reply_ids.size(), kMaxFrames);
  }
  if (options.length > 8 && !options.fd) {
    fail("a classic frame holds at most 8 bytes, not %d; add --fd", options.length);
  }
}

}  // namespace

BareOptions parse_bare_options(int argc, char** argv) {
  const auto with_value = [](const char* name) {
    return option{name, required_argument, nullptr, 0};
  };
  const auto flag = [](const char* name) { return option{name, no_argument, nullptr, 0}; };
  const std::array<option, 16> known{with_value("count"),
                                     with_value("ids"),
                                     with_value("reply-ids"),
                                     flag("extended"),
                                     with_value("length"),
                                     flag("fd"),
                                     with_value("cycles"),
                                     with_value("warm-up"),
                                     with_value("rate"),
                                     with_value("budget"),
                                     with_value("priority"),
                                     with_value("cpu"),
                                     with_value("reply-gap"),
                                     flag("json"),
                                     flag("help"),
                                     option{}};
  BareOptions options;
  std::size_t count = 7;
  int index = 0;
  for (int c = 0; (c = ::getopt_long(argc, argv, "h", known.data(), &index)) != -1;) {
    if (c != 0 || std::strcmp(known[static_cast<std::size_t>(index)].name, "help") == 0) {
      std::fputs(kUsage, c == '?' ? stderr : stdout);
      std::exit(c == '?' ? 2 : 0);
    }
    set(options, count, known[static_cast<std::size_t>(index)].name, optarg ? optarg : "");
  }
  if (argc - optind != 2) {
    std::fputs(kUsage, stderr);
    std::exit(2);
  }
  options.role = argv[optind];
  options.buses = split(argv[optind + 1]);
  for (std::uint32_t id = 1; options.ids.size() < count; ++id) {
    options.ids.push_back(id);
  }
  if (options.reply_ids.empty()) {
    for (const std::uint32_t id : options.ids) {
      options.reply_ids.push_back(id + 16);
    }
  }
  check(options);
  return options;
}

}  // namespace geodesic::bench
