#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

/// Checksums that several ranks can take of their own parts of a file, in any order.
namespace impact {

/// A one-to-one map of 64 bits whose every output bit depends on every input bit: the finaliser of splitmix64
/// (Steele, Lea, Flood 2014).
inline std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// sum_i (2 i + 1) mixed(w_i) mod 2^64 over the words w_i of eight bytes, the last one filled up with zeros;
/// `first_word` is the number i of the first. The sums of the parts of a file add up to that of the file. A
/// change within one word is always seen, any other with a chance of one in 2^64 to be missed. Words of zeros
/// add nothing, so the length of a file has to be kept beside its sum.
inline std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t first_word = 0) {
  std::uint64_t sum = 0, word = 0;
  std::size_t i = 0;
  for (; 8 * (i + 1) <= bytes.size(); ++i) {
    std::memcpy(&word, bytes.data() + 8 * i, 8);
    sum += (2 * (first_word + i) + 1) * mixed(word);
  }
  word = 0;
  if (const std::size_t rest = bytes.size() - 8 * i; rest > 0) {
    std::memcpy(&word, bytes.data() + 8 * i, rest);
    sum += (2 * (first_word + i) + 1) * mixed(word);
  }
  return sum;
}

inline std::uint64_t checksum(const std::string& text) { return checksum(std::as_bytes(std::span(text))); }

/// `value` as 16 hexadecimal digits.
inline std::string to_hex(std::uint64_t value) {
  std::string text(16, '0');
  for (std::size_t i = 16; i-- > 0; value >>= 4) text[i] = "0123456789abcdef"[value & 15];
  return text;
}

} // namespace impact
