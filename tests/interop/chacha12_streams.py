#!/usr/bin/env python3
"""The first random numbers of every stream, implemented independently of Kinetoscope.

Plain Python 3, no packages. ChaCha with 12 rounds (Bernstein 2008): the seed, little-endian, is the
key's first 8 bytes, the rest is zero; the block counter is words 12 and 13, the 64-bit stream number
replicate * 2^32 + purpose is words 14 and 15. A uniform number is the upper 53 bits of 64, times 2^-53.
tests/guarantees/random_streams_are_pinned.rs contains the output: seed, replicate, purpose, then the 53-bit
numbers of draws 1, 2, 3 and 1000.
"""

import struct

MASK = 0xFFFFFFFF


def chacha_block(key, counter, stream, rounds=12):
    start = list(struct.unpack("<4I", b"expand 32-byte k")) + list(struct.unpack("<8I", key))
    start += [counter & MASK, counter >> 32, stream & MASK, stream >> 32]
    words = start[:]

    def quarter_round(a, b, c, d):
        for x, y, z, turn in ((a, b, d, 16), (c, d, b, 12), (a, b, d, 8), (c, d, b, 7)):
            words[x] = (words[x] + words[y]) & MASK
            words[z] ^= words[x]
            words[z] = ((words[z] << turn) | (words[z] >> (32 - turn))) & MASK

    for _ in range(rounds // 2):
        for column in range(4):
            quarter_round(column, 4 + column, 8 + column, 12 + column)
        for column in range(4):
            quarter_round(column, 4 + (column + 1) % 4, 8 + (column + 2) % 4, 12 + (column + 3) % 4)
    return struct.pack("<16I", *((a + b) & MASK for a, b in zip(words, start)))


def draw(seed, replicate, purpose, number):
    """The 53-bit number of one draw, counted from 1."""
    key = struct.pack("<Q", seed) + bytes(24)
    block = chacha_block(key, (number - 1) // 8, replicate << 32 | purpose)
    return struct.unpack("<8Q", block)[(number - 1) % 8] >> 11


# Published keystreams of a zero key and nonce: 12 rounds (draft-strombergson-chacha-test-vectors, TC1), 20 rounds (RFC 8439).
assert chacha_block(bytes(32), 0, 0).hex().startswith("9bf49a6a0755f953811fce125f2683d5")
assert chacha_block(bytes(32), 0, 0, rounds=20).hex().startswith("76b8e0ada0f13d90405d6ae55386bd28")

if __name__ == "__main__":
    for seed in (14, 0x0123456789ABCDEF):
        for replicate in (0, 3):
            for purpose in (1, 2, 3, 4):
                numbers = [draw(seed, replicate, purpose, number) for number in (1, 2, 3, 1000)]
                print(hex(seed), replicate, purpose, *map(hex, numbers))
