// Stores curves as half.wgsl reads them. Needs the part curve.wgsl and
//   fn avsm_set_word(index: u32, word: u32)    the words of the map

// The depth of a node in 16 bits, as a share of the way between the first and the last.
fn avsm_half_depth(curve: ptr<function, avsm_Curve>, ends: vec2<f32>, node: u32) -> u32 {
    let last = max((*curve).len, 1u) - 1u;
    let share = avsm_shares(ends, (*curve).depth[min(node, last)]).y;
    return u32(round(share * avsm_LAST));
}

// A number from 0 to 65504 in 16 bits, rounded to the nearest, ties to even.
fn avsm_to_half(x: f32) -> u32 {
    if x < 0x1p-14 {
        return u32(round(x * 0x1p+24));
    }
    let bits = bitcast<u32>(x) - (112u << 23u);
    return (bits + 0xfffu + ((bits >> 13u) & 1u)) >> 13u;
}

// The value of a node as an f16; nodes that the curve does not have repeat its last.
fn avsm_half_value(curve: ptr<function, avsm_Curve>, node: u32, channel: u32) -> u32 {
    if (*curve).len == 0u {
        return avsm_to_half(avsm_CLEAR);
    }
    // An optical depth beyond the range of f16 is opaque either way.
    let value = (*curve).value[channel * avsm_CAPACITY + min(node, (*curve).len - 1u)];
    return avsm_to_half(min(value, 65504.0));
}

// Stores a curve: the depths of its ends, then the rows of pairs.
fn avsm_store(texel: u32, curve: ptr<function, avsm_Curve>) {
    let base = texel * avsm_WORDS;
    let ends = vec2((*curve).depth[0], (*curve).depth[max((*curve).len, 1u) - 1u]);
    avsm_set_word(base, bitcast<u32>(ends.x));
    avsm_set_word(base + 1u, bitcast<u32>(ends.y));
    for (var i = 0u; i < avsm_PAIRS; i++) {
        let nodes = 2u * i + vec2(0u, 1u);
        // With an odd number of nodes the last one has no second.
        let is_pair = nodes.y < avsm_NODES;
        let low = avsm_half_depth(curve, ends, nodes.x);
        let high = select(0u, avsm_half_depth(curve, ends, nodes.y), is_pair);
        avsm_set_word(base + 2u + i, low | (high << 16u));
        for (var c = 0u; c < avsm_CHANNELS; c++) {
            let first = avsm_half_value(curve, nodes.x, c);
            let second = select(0u, avsm_half_value(curve, nodes.y, c), is_pair);
            avsm_set_word(base + 2u + (1u + c) * avsm_PAIRS + i, first | (second << 16u));
        }
    }
}
