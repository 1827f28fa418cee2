#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace gyrator {

/// The four tables of a Modbus device: coils and discrete inputs hold bits, input and holding
/// registers words of 16 bits; coils and holding registers can be written.
enum class RegisterTable { coil, discrete, input, holding };

/// How a number stands in registers: bit in one coil or discrete input (or as 0 and 1 in a
/// register), the others in one, two or four registers.
enum class RegisterType { bit, u16, i16, u32, i32, u64, f32, f64 };

/// Which byte comes first. With A the most significant byte of a 32-bit number: abcd as the Modbus
/// specification has 16-bit numbers, cdab with the words reversed, badc with the bytes of every
/// word swapped, dcba with both. Of 64 bits, likewise: abcdefgh, ghefcdab, badcfehg, hgfedcba.
/// Of 16 bits: ab for abcd and cdab, ba for badc and dcba.
enum class WordOrder { abcd, badc, cdab, dcba };

std::string_view name_of(RegisterTable table);  ///< "coil", "discrete", "input", "holding"
std::string_view name_of(RegisterType type);    ///< "u16"
std::string_view name_of(WordOrder order);      ///< "ABCD"

std::optional<RegisterTable> find_register_table(std::string_view name);
std::optional<RegisterType> find_register_type(std::string_view name);
std::optional<WordOrder> find_word_order(std::string_view name);  ///< upper or lower case

/// Whether the table holds bits, rather than words.
bool holds_bits(RegisterTable table);
/// Whether a client may write to the table.
bool is_writable(RegisterTable table);

/// "holding 0x0010 (40017)": the address as it goes over the wire, from 0, and the number that
/// manuals print (from 1, its first digit the table; six digits where five do not do).
std::string describe_address(RegisterTable table, int address);

/// A number as the registers hold it, before any scale: std::uint64_t for bit, u16, u32 and u64,
/// std::int64_t for i16 and i32, double for f32 and f64.
using RawValue = std::variant<std::uint64_t, std::int64_t, double>;

/// Registers that a value takes; 1 for a bit.
int words_of(RegisterType type);

/// The registers that hold the value. The inverse of decode_value in every bit, of not-a-numbers
/// too. Takes the value in any of RawValue's types, if the register's type has it: whole and
/// within its range. An f32 is rounded to the nearest one. Throws bad_input, without a place,
/// for what it has not.
std::vector<std::uint16_t> encode_value(const RawValue& value, RegisterType type, WordOrder order);

/// The value that words_of(type) registers hold; bad_input, without a place, for another number of
/// them.
RawValue decode_value(std::span<const std::uint16_t> words, RegisterType type, WordOrder order);

/// The bits of 1, 2 or 4 registers as one unsigned number, most significant first: what bit fields
/// are cut from, and what a sentinel ("not implemented") is compared with.
std::uint64_t decode_pattern(std::span<const std::uint16_t> words, WordOrder order);
std::vector<std::uint16_t> encode_pattern(std::uint64_t pattern, int words, WordOrder order);

/// The value as a double; rounded above 2^53.
double to_double(const RawValue& value);

}  // namespace gyrator
