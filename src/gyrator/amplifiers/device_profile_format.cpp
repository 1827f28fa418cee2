// The profile of an amplifier as a table: what the keys are, and what they mean.
#include "gyrator/amplifiers/device_profile.hpp"

namespace gyrator {
namespace {

std::vector<std::string> upper_orders() {
  return {"ABCD", "BADC", "CDAB", "DCBA"};
}

std::vector<std::string> type_names() {
  std::vector<std::string> names;
  for (const auto type :
       {RegisterType::bit, RegisterType::u16, RegisterType::i16, RegisterType::u32,
        RegisterType::i32, RegisterType::u64, RegisterType::f32, RegisterType::f64})
    names.emplace_back(name_of(type));
  return names;
}

// Where a number stands and how it is written there: of registers and of capture windows.
std::vector<Member> number_members(const char* address_meaning) {
  return {
      member::integer("address").required().at_least(0).at_most(65535).doc(address_meaning),
      member::choice("type", type_names())
          .doc("How the number is written. Required but for coils and discrete inputs, which are "
               "bits."),
      member::choice("order", upper_orders())
          .doc("Which byte comes first, A the most significant one. Absent: the profile's."),
      member::number("scale").by_default(1).doc(
          "Value = (raw x scale + offset) in `unit`; on writes the inverse."),
      member::number("offset").by_default(0).doc("In `unit`: 273.15 of a raw in degrees Celsius."),
      member::text("unit").by_default("").doc(
          "Of the value, such as \"mA\", \"uF\", \"K\", \"rad/s\"; empty: SI, or a pure number."),
      member::anything("not_implemented")
          .doc("The raw number by which the device says that it has no such value. A float that is "
               "no number always says so."),
  };
}

ObjectSpec bits_spec() {
  return {"bits",
          "Some bits of a word, which share it with other registers.",
          {
              member::integer("first").required().at_least(0).at_most(63).doc(
                  "The least significant of them, from 0."),
              member::integer("count").by_default(1).at_least(1).at_most(32).doc("How many."),
          }};
}

ObjectSpec register_spec() {
  ObjectSpec spec{
      "register",
      "A value of the device by name. The numbers of `min`, `max`, `step` and `safe` "
      "are in `unit`; a text may have another unit of the same kind, or be a code.",
      {
          member::text("name").required().doc("The well-known ones mean the same on every device."),
          member::choice("table", {"coil", "discrete", "input", "holding"})
              .by_default("holding")
              .doc("Of the device's four tables."),
      }};
  for (Member& number :
       number_members("Of its first word, from 0 as on the wire: 16 is what manuals call 40017."))
    spec.members.push_back(std::move(number));
  for (Member& more : std::vector<Member>{
           member::object("bits", bits_spec()).doc("Of a word that several values share."),
           member::anything("codes").doc(
               "Names of its values, {\"current\": 0, \"voltage\": 1}; no other can be written."),
           member::anything("min").doc("Least value that may be written."),
           member::anything("max").doc("Largest value that may be written."),
           member::anything("step").doc("Of the values that may be written, from `min` or 0."),
           member::anything("safe").doc(
               "Written when a session ends in the safe state. Absent: it is left as it is."),
           member::choice("access", {"read_write", "read", "write"})
               .doc("Absent: read_write for coils and holding registers, read for the others."),
           member::text("group").by_default("").doc("Heading in tables."),
           member::choice("store", {"ram", "persistent"})
               .by_default("ram")
               .doc("Persistent ones outlast a power cycle, wear, and are written only with "
                    "--persist."),
           member::text("write_cost")
               .by_default("")
               .doc("Of a persistent one, in words: \"100000 writes in its life\"."),
           member::quantity("settle", dimension::time)
               .by_default(0)
               .at_least(0)
               .at_most(60)
               .doc("From a write until it can be read back."),
           member::boolean("setting").doc(
               "Kept by a backup and put back by a restore. Absent: if it can be read and written "
               "and is no part of fault, watchdog, persist, clock, excitation or capture."),
           member::text("caveat").by_default("").doc("What to know before it is touched."),
       })
    spec.members.push_back(std::move(more));
  return spec;
}

ObjectSpec action_spec() {
  return {
      "action",
      "A value to write for something to happen.",
      {
          member::text("register").required().doc("Name of a register that can be written."),
          member::anything("value").by_default(1).doc("Number in the register's unit, or code."),
      }};
}

ObjectSpec with_more(ObjectSpec spec, std::vector<Member> more) {
  for (Member& one : more) spec.members.push_back(std::move(one));
  return spec;
}

ObjectSpec link_spec() {
  return {"link",
          "How the device wants to be talked to.",
          {
              member::integer("unit").by_default(1).at_least(0).at_most(255).doc(
                  "Its Modbus address; --unit gives another."),
              member::quantity("response_timeout", dimension::time)
                  .by_default("0.5 s")
                  .above(0)
                  .at_most(60)
                  .doc("Until an answer begins; --timeout gives another."),
              member::quantity("byte_timeout", dimension::time)
                  .by_default("0.1 s")
                  .above(0)
                  .at_most(60)
                  .doc("Between two bytes of an answer."),
              member::quantity("gap", dimension::time)
                  .by_default(0)
                  .at_least(0)
                  .at_most(10)
                  .doc("Silence before each request, at least."),
              member::integer("retries").by_default(3).at_least(0).at_most(20).doc(
                  "Of a read that failed; a write is never sent twice by itself."),
              member::quantity("backoff", dimension::time)
                  .by_default("20 ms")
                  .at_least(0)
                  .at_most(10)
                  .doc("Before the first retry; doubles with each."),
              member::integer("max_read")
                  .by_default(125)
                  .at_least(1)
                  .at_most(125)
                  .doc("Registers in a request."),
              member::integer("max_write")
                  .by_default(123)
                  .at_least(1)
                  .at_most(123)
                  .doc("Registers in a request."),
              member::integer("max_hole")
                  .by_default(8)
                  .at_least(0)
                  .at_most(124)
                  .doc("Most registers of no name between two that are read in one request."),
              member::boolean("single_register_writes")
                  .by_default(true)
                  .doc("One register is written by function 6; false: by function 16."),
          }};
}

ObjectSpec fault_spec() {
  return {"fault",
          "How the device says what is wrong.",
          {
              member::text("register").required().doc("Name of the register with a bit for each."),
              member::anything("bits").required().doc(
                  "What the bits mean, {\"0\": \"overcurrent\", \"1\": \"overtemperature\"}."),
              member::object("clear", action_spec()).doc("Takes the fault back."),
          }};
}

ObjectSpec watchdog_spec() {
  return with_more({"watchdog",
                    "A register that must be written again and again while the drive is on, or the "
                    "device switches it off.",
                    action_spec().members},
                   {member::quantity("period", dimension::time)
                        .required()
                        .above(0)
                        .doc("Longest time between two writes.")});
}

ObjectSpec persist_spec() {
  return with_more({"persist", "What makes the device keep its settings over a power cycle.",
                    action_spec().members},
                   {member::text("cost").by_default("").doc("In words.")});
}

ObjectSpec clock_spec() {
  return {"clock",
          "Of a simulated device, whose time is not the world's: waiting moves it.",
          {
              member::text("time").required().doc("Register that has its time."),
              member::text("advance").required().doc("Register that moves it by what is written."),
          }};
}

ObjectSpec excitation_spec() {
  return {"excitation",
          "The generator of the command: registers by name. In current mode amplitude and offset "
          "are in A, in voltage mode in V.",
          {
              member::text("kind").required().doc("Its codes are of dc, step, sine, chirp, prbs."),
              member::text("amplitude").required().doc("Amplitude."),
              member::text("offset").required().doc("Offset."),
              member::text("frequency").doc("Of sine; first of chirp; bits per second of prbs."),
              member::text("end_frequency").doc("Last of chirp."),
              member::text("duration").required().doc("Duration; the command is zero after it."),
              member::object("start", action_spec()).required().doc("Begins it."),
              member::object("stop", action_spec()).required().doc("Ends it at once."),
          }};
}

ObjectSpec window_spec() {
  return {"window", "One signal's samples, one after another in the table.",
          with_more({"",
                     "",
                     {member::choice("table", {"input", "holding"})
                          .by_default("input")
                          .doc("Of the device's tables of registers.")}},
                    number_members("Of the first sample, from 0."))
              .members};
}

ObjectSpec capture_spec() {
  ObjectSpec signals{"signals", "What the buffer keeps, each in a window of its own.", {}};
  for (const auto& [name, meaning] :
       {std::pair{"command", "That the generator gave, A or V."},
        std::pair{"current", "In the winding."}, std::pair{"voltage", "At the motor's terminals."},
        std::pair{"velocity", "Of the rotor."}, std::pair{"position", "Of the rotor."}})
    signals.members.push_back(member::object(name, window_spec()).doc(meaning));
  const ObjectSpec page{
      "page",
      "A window that shows a part of the buffer at a time.",
      {
          member::text("register").required().doc("Register that takes the part's number, from 0."),
          member::integer("samples").required().at_least(1).at_most(65536).doc("In each part."),
      }};
  return {
      "capture",
      "The buffer that keeps signals at the device's own pace: registers by name.",
      {
          member::quantity("period", dimension::time)
              .required()
              .above(0)
              .doc("Between two samples with a decimation of 1."),
          member::integer("max_samples").required().at_least(1).at_most(1e6).doc("Of each signal."),
          member::text("delay").doc("From the excitation's begin to the first sample."),
          member::text("decimation").doc("Every how manieth sample is kept."),
          member::text("samples").required().doc("How many samples are kept."),
          member::object("arm", action_spec())
              .required()
              .doc("The next excitation begins the capture."),
          member::text("state").required().doc("Has a code \"done\"."),
          member::object("signals", std::move(signals)).required().doc("What is kept."),
          member::object("page", page).doc("Absent: the windows show everything."),
      }};
}

}  // namespace

const Member& amplifier_format() {
  static const Member format = member::object(
      "amplifier",
      {"amplifier",
       "An amplifier's registers and how to work with them, for `gyrator identify`, `tune`, "
       "`backup`, `diff` and `restore`.",
       {
           member::choice("schema", {amplifier_schema_name})
               .required()
               .doc("Version of the format."),
           member::text("name").required().doc("Shown in messages and kept in journals."),
           member::text("caveats").by_default("").doc("What to know about the device."),
           member::choice("order", upper_orders())
               .by_default("ABCD")
               .doc("Of the bytes of a number; a register may have its own."),
           member::object("link", link_spec())
               .by_default(nlohmann::json::object())
               .doc("How the device wants to be talked to."),
           member::object("registers", register_spec()).list(1).required().doc("By name."),
           member::object("identity", with_more({"identity",
                                                 "What a register reads on such a device.",
                                                 {action_spec().members.front()}},
                                                {member::anything("value").required().doc(
                                                    "Number in the register's unit, or code.")}))
               .list()
               .by_default(nlohmann::json::array())
               .doc("Checked before anything else."),
           member::object("fault", fault_spec()).doc("What is wrong."),
           member::object("watchdog", watchdog_spec()).doc("Must be fed."),
           member::object("persist", persist_spec()).doc("Keeps settings."),
           member::object("clock", clock_spec()).doc("Absent: the device lives in real time."),
           member::object("excitation", excitation_spec()).doc("The generator."),
           member::object("capture", capture_spec()).doc("The buffer."),
       }});
  return format;
}

}  // namespace gyrator
