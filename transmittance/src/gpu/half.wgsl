// Curves as `PackedHalf` stores them. Needs
//   fn avsm_word(index: u32) -> u32    the words of the map

const avsm_PAIRS: u32 = (avsm_NODES + 1u) / 2u;
const avsm_WORDS: u32 = 2u + avsm_PAIRS * (1u + avsm_CHANNELS);

// The largest depth of 16 bits, which the last node has.
const avsm_LAST: f32 = 65535.0;

fn avsm_stored_len(texel: u32) -> u32 {
    return avsm_NODES;
}

// The word with the numbers of a node and of its neighbour: row 0 has the depths, the
// others have the values of each channel.
fn avsm_pair(texel: u32, row: u32, node: u32) -> u32 {
    return avsm_word(texel * avsm_WORDS + 2u + row * avsm_PAIRS + node / 2u);
}

fn avsm_stored_depth(texel: u32, node: u32) -> f32 {
    return f32((avsm_pair(texel, 0u, node) >> (16u * (node % 2u))) & 0xffffu);
}

// The value of an f16 that is not negative. Converted by hand, because f16 is not part of
// what every device can do.
fn avsm_from_half(half: u32) -> f32 {
    if half < 0x400u {
        return f32(half) * 0x1p-24;
    }
    return bitcast<f32>((half << 13u) + (112u << 23u));
}

fn avsm_stored_value(texel: u32, node: u32, channel: u32) -> f32 {
    return avsm_from_half((avsm_pair(texel, 1u + channel, node) >> (16u * (node % 2u))) & 0xffffu);
}

// A depth in the measure of the stored ones: 0 at the first node, avsm_LAST at the last.
fn avsm_place(texel: u32, depth: f32) -> f32 {
    let first = bitcast<f32>(avsm_word(texel * avsm_WORDS));
    let last = bitcast<f32>(avsm_word(texel * avsm_WORDS + 1u));
    // A blocker casts no shadow at its own depth, also at that of the first node.
    if depth <= first {
        return -1.0;
    }
    if depth > last {
        return avsm_LAST + 1.0;
    }
    return clamp(avsm_shares(vec2(first, last), depth).y * avsm_LAST, 1e-30, avsm_LAST);
}

// The depth of a place in that measure.
fn avsm_unplace(texel: u32, place: f32) -> f32 {
    let first = bitcast<f32>(avsm_word(texel * avsm_WORDS));
    let last = bitcast<f32>(avsm_word(texel * avsm_WORDS + 1u));
    let share = place / avsm_LAST;
    return clamp(first * (1.0 - share) + last * share, first, last);
}
